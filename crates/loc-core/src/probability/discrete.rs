//! Distributions over a finite set of outcomes, and joint tables of two variables.

use crate::error::{in_range, non_negative};
use crate::sampling::CumulativeTable;
use crate::{Error, Result};
use rand::Rng;

/// How far a sum of probabilities may be from 1, and a product from the probability of two
/// independent events.
pub(super) const TOLERANCE: f64 = 1e-9;

/// A distribution over labelled outcomes: at least one, their probabilities >= 0 with sum 1.
///
/// Outcomes need not differ: equal labels are separate outcomes of the same name.
#[derive(Debug, Clone, PartialEq)]
pub struct Discrete<T> {
    outcomes: Vec<T>,
    probabilities: Vec<f64>,
    cumulative: CumulativeTable,
}

impl<T> Discrete<T> {
    /// A distribution from pairs (outcome, probability).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a probability that is negative or not finite, and where their sum
    /// is not 1 within 1e-9 (no pairs included).
    pub fn new(pairs: impl IntoIterator<Item = (T, f64)>) -> Result<Self> {
        let (outcomes, probabilities): (Vec<T>, Vec<f64>) = pairs.into_iter().unzip();
        check_probabilities(&probabilities)?;
        Ok(Discrete::from_checked(outcomes, probabilities))
    }

    /// Every outcome with the same probability.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] without outcomes.
    pub fn uniform(outcomes: impl IntoIterator<Item = T>) -> Result<Self> {
        Discrete::from_weights(outcomes.into_iter().map(|outcome| (outcome, 1.0)))
    }

    /// Probabilities in proportion to the weights of pairs (outcome, weight).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a weight that is negative or not finite, and where their sum is
    /// 0 (no pairs included) or overflows.
    pub fn from_weights(pairs: impl IntoIterator<Item = (T, f64)>) -> Result<Self> {
        let (outcomes, weights): (Vec<T>, Vec<f64>) = pairs.into_iter().unzip();
        let total = CumulativeTable::new(weights.iter().copied())?.total();
        let probabilities = weights.iter().map(|weight| weight / total).collect();
        Ok(Discrete::from_checked(outcomes, probabilities))
    }

    /// A distribution of probabilities that are known to be finite, >= 0, and to sum to 1.
    pub(super) fn from_checked(outcomes: Vec<T>, probabilities: Vec<f64>) -> Self {
        Discrete {
            outcomes,
            cumulative: CumulativeTable::from_checked(&probabilities),
            probabilities,
        }
    }

    /// The outcomes, in the order given.
    pub fn outcomes(&self) -> &[T] {
        &self.outcomes
    }

    /// The probabilities, in the order of the outcomes.
    pub fn probabilities(&self) -> &[f64] {
        &self.probabilities
    }

    /// Pairs (outcome, probability).
    pub fn iter(&self) -> impl Iterator<Item = (&T, f64)> {
        self.outcomes.iter().zip(self.probabilities.iter().copied())
    }

    /// Probability of the event that holds the outcomes for which `event` is true.
    pub fn probability(&self, event: impl Fn(&T) -> bool) -> f64 {
        let members = self.iter().filter(|(outcome, _)| event(outcome));
        members.map(|(_, p)| p).sum()
    }

    /// The distribution given that `event` happened: P(a | e) = P(a and e) / P(e).
    ///
    /// # Errors
    /// [`Error::ImpossibleEvidence`] where the event has probability 0.
    pub fn given(&self, event: impl Fn(&T) -> bool) -> Result<Discrete<T>>
    where
        T: Clone,
    {
        let members: Vec<(T, f64)> = self
            .iter()
            .filter(|(outcome, _)| event(outcome))
            .map(|(outcome, p)| (outcome.clone(), p))
            .collect();
        if members.iter().all(|&(_, p)| p <= 0.0) {
            let what = "conditional distribution";
            return Err(Error::ImpossibleEvidence { what });
        }
        Discrete::from_weights(members)
    }

    /// Whether two events are independent: P(a and b) = P(a) P(b) within 1e-9.
    pub fn independent(&self, a: impl Fn(&T) -> bool, b: impl Fn(&T) -> bool) -> bool {
        let both = self.probability(|outcome| a(outcome) && b(outcome));
        (both - self.probability(a) * self.probability(b)).abs() <= TOLERANCE
    }

    /// Expected value of a number that depends on the outcome: E(f) = sum f(x) P(x).
    ///
    /// Outcomes of probability 0 do not count, whatever value `f` gives them.
    pub fn expectation(&self, f: impl Fn(&T) -> f64) -> f64 {
        let possible = self.iter().filter(|&(_, p)| p > 0.0);
        possible.map(|(outcome, p)| f(outcome) * p).sum()
    }

    /// Variance of a number that depends on the outcome: E((f - E(f))^2).
    pub fn variance(&self, f: impl Fn(&T) -> f64) -> f64 {
        let mean = self.expectation(&f);
        self.expectation(|outcome| (f(outcome) - mean).powi(2))
    }

    /// Covariance of two numbers that depend on the outcome: E((f - E(f)) (g - E(g))).
    pub fn covariance(&self, f: impl Fn(&T) -> f64, g: impl Fn(&T) -> f64) -> f64 {
        let (f_mean, g_mean) = (self.expectation(&f), self.expectation(&g));
        self.expectation(|outcome| (f(outcome) - f_mean) * (g(outcome) - g_mean))
    }

    /// The outcome of the highest probability, the first of several.
    pub fn most_likely(&self) -> &T {
        let mut best = 0;
        for (index, &p) in self.probabilities.iter().enumerate() {
            if p > self.probabilities[best] {
                best = index;
            }
        }
        &self.outcomes[best]
    }

    /// Entropy `-sum p ln p` \[nat\]: 0 for certainty, ln n where n outcomes are equally likely.
    pub fn entropy(&self) -> f64 {
        let possible = self.probabilities.iter().filter(|&&p| p > 0.0);
        possible.map(|&p| -p * p.ln()).sum::<f64>().max(0.0)
    }

    /// Draws an outcome by the inverse of the cumulative distribution (F4).
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> &T {
        &self.outcomes[self.cumulative.sample(rng)]
    }

    /// The distribution of a random variable, a function of the outcome; outcomes with equal
    /// values are added up.
    pub fn map<U: PartialEq>(&self, variable: impl Fn(&T) -> U) -> Discrete<U> {
        let (mut values, mut sums): (Vec<U>, Vec<f64>) = (Vec::new(), Vec::new());
        for (outcome, p) in self.iter() {
            let value = variable(outcome);
            match values.iter().position(|known| *known == value) {
                Some(index) => sums[index] += p,
                None => {
                    values.push(value);
                    sums.push(p);
                }
            }
        }
        Discrete::from_checked(values, sums)
    }
}

/// Checks that probabilities are >= 0, finite, and sum to 1 within 1e-9.
pub(super) fn check_probabilities(probabilities: &[f64]) -> Result<()> {
    let mut sum = 0.0;
    for &p in probabilities {
        sum += non_negative("probability", p)?;
    }
    let normalized = |sum: f64| (sum - 1.0).abs() <= TOLERANCE;
    in_range("sum of the probabilities", "1 within 1e-9", sum, normalized)?;
    Ok(())
}

/// The joint distribution P(A, B) of two variables: a table with a row for each value of A and a
/// column for each value of B.
///
/// ```
/// use loc_core::probability::Joint;
/// let table = Joint::new(
///     ["no cavity", "cavity"],
///     ["sunny", "cloudy", "rainy", "frosty"],
///     &[[0.225, 0.36, 0.27, 0.045], [0.025, 0.04, 0.03, 0.005]],
/// )?;
/// let weather = table.second_given(&"no cavity")?;
/// assert!((weather.probability(|&w| w == "sunny") - 0.225 / 0.9).abs() < 1e-12);
/// assert!(table.is_independent(), "weather and teeth are independent");
/// # Ok::<(), loc_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Joint<A, B> {
    first: Vec<A>,
    second: Vec<B>,
    /// Row by row.
    cells: Vec<f64>,
}

impl<A: Clone, B: Clone> Joint<A, B> {
    /// A table from the values of both variables and its rows, one for each value of the first.
    ///
    /// # Errors
    /// [`Error::Length`] where the table does not have a row for each value of the first variable
    /// and in it a column for each of the second; [`Error::OutOfRange`] for a probability that is
    /// negative or not finite, and where their sum is not 1 within 1e-9.
    pub fn new<Row: AsRef<[f64]>>(
        first: impl IntoIterator<Item = A>,
        second: impl IntoIterator<Item = B>,
        rows: &[Row],
    ) -> Result<Self> {
        let first: Vec<A> = first.into_iter().collect();
        let second: Vec<B> = second.into_iter().collect();
        let wrong_length = |what, expected, found| Error::Length { what, expected, found };
        if rows.len() != first.len() {
            let expected = "a row for each value of the first variable";
            return Err(wrong_length("rows of a joint table", expected, rows.len()));
        }
        for row in rows.iter().map(AsRef::as_ref) {
            if row.len() != second.len() {
                let expected = "a column for each value of the second variable";
                return Err(wrong_length("row of a joint table", expected, row.len()));
            }
        }
        let cells: Vec<f64> = rows.iter().flat_map(AsRef::as_ref).copied().collect();
        check_probabilities(&cells)?;
        Ok(Joint { first, second, cells })
    }

    /// The table of two independent variables: P(A, B) = P(A) P(B).
    pub fn product(first: &Discrete<A>, second: &Discrete<B>) -> Self {
        let row = |p: f64| second.probabilities().iter().map(move |q| p * q);
        Joint {
            first: first.outcomes().to_vec(),
            second: second.outcomes().to_vec(),
            cells: first.probabilities().iter().flat_map(|&p| row(p)).collect(),
        }
    }

    /// The table from the distribution of the first variable and that of the second under it, by
    /// the product rule P(A, B) = P(B | A) P(A).
    ///
    /// `conditional(a, b)` is P(b | a).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where P(B | a) of some `a` is not a distribution: a probability
    /// negative or not finite, or a sum that is not 1 within 1e-9.
    pub fn from_conditional(
        prior: &Discrete<A>,
        second: impl IntoIterator<Item = B>,
        conditional: impl Fn(&A, &B) -> f64,
    ) -> Result<Self> {
        let second: Vec<B> = second.into_iter().collect();
        let mut cells = Vec::with_capacity(prior.outcomes().len() * second.len());
        for (a, p) in prior.iter() {
            let row: Vec<f64> = second.iter().map(|b| conditional(a, b)).collect();
            check_probabilities(&row)?;
            cells.extend(row.iter().map(|q| q * p));
        }
        Ok(Joint { first: prior.outcomes().to_vec(), second, cells })
    }

    /// The distribution over the cells of the table, pairs (a, b), row by row: for events,
    /// expectations and covariances that involve both variables.
    pub fn cells(&self) -> Discrete<(A, B)> {
        let pairs = self.first.iter().flat_map(|a| {
            let column = self.second.iter();
            column.map(move |b| (a.clone(), b.clone()))
        });
        Discrete::from_checked(pairs.collect(), self.cells.clone())
    }

    /// The distribution P(A) of the first variable alone.
    pub fn first(&self) -> Discrete<A> {
        let sums = self.rows().map(|row| row.iter().sum()).collect();
        Discrete::from_checked(self.first.clone(), sums)
    }

    /// The distribution P(B) of the second variable alone.
    pub fn second(&self) -> Discrete<B> {
        let columns = 0..self.second.len();
        let sums = columns.map(|column| self.column(column).sum()).collect();
        Discrete::from_checked(self.second.clone(), sums)
    }

    /// The distribution P(A | b) of the first variable once the second is known.
    ///
    /// # Errors
    /// [`Error::ImpossibleEvidence`] where `b` has probability 0 or is not in the table.
    pub fn first_given(&self, b: &B) -> Result<Discrete<A>>
    where
        B: PartialEq,
    {
        let known = self.second.iter().position(|value| value == b);
        let weights = known.map_or_else(Vec::new, |column| self.column(column).collect());
        conditional(&self.first, &weights)
    }

    /// The distribution P(B | a) of the second variable once the first is known.
    ///
    /// # Errors
    /// [`Error::ImpossibleEvidence`] where `a` has probability 0 or is not in the table.
    pub fn second_given(&self, a: &A) -> Result<Discrete<B>>
    where
        A: PartialEq,
    {
        let known = self.first.iter().position(|value| value == a);
        let weights = known.and_then(|row| self.rows().nth(row));
        conditional(&self.second, weights.unwrap_or_default())
    }

    /// Whether the variables are independent: P(a, b) = P(a) P(b) within 1e-9 in every cell.
    pub fn is_independent(&self) -> bool {
        let product = Joint::product(&self.first(), &self.second());
        let mut pairs = self.cells.iter().zip(&product.cells);
        pairs.all(|(p, q)| (p - q).abs() <= TOLERANCE)
    }

    /// Covariance of a number that depends on the first variable with one that depends on the
    /// second, E((f - E(f)) (g - E(g))) (F2). Independent variables have 0, but not only they.
    pub fn covariance(&self, f: impl Fn(&A) -> f64, g: impl Fn(&B) -> f64) -> f64 {
        self.cells().covariance(|(a, _)| f(a), |(_, b)| g(b))
    }

    /// Correlation: the covariance divided by both standard deviations, in \[-1, 1\] (F2).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where one of the numbers does not vary.
    pub fn correlation(&self, f: impl Fn(&A) -> f64, g: impl Fn(&B) -> f64) -> Result<f64> {
        let (f_variance, g_variance) = (self.first().variance(&f), self.second().variance(&g));
        crate::stats::normalized(self.covariance(f, g), f_variance, g_variance)
    }

    fn rows(&self) -> std::slice::Chunks<'_, f64> {
        self.cells.chunks(self.second.len())
    }

    fn column(&self, index: usize) -> impl Iterator<Item = f64> {
        self.rows().map(move |row| row[index])
    }
}

/// The distribution in proportion to one row or column of a table.
fn conditional<T: Clone>(outcomes: &[T], weights: &[f64]) -> Result<Discrete<T>> {
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        let what = "conditional distribution";
        return Err(Error::ImpossibleEvidence { what });
    }
    let probabilities = weights.iter().map(|weight| weight / total).collect();
    Ok(Discrete::from_checked(outcomes.to_vec(), probabilities))
}
