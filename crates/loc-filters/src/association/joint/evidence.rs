//! Whether pairs say more than chance.

use super::innovation::JointInnovation;
use crate::association::Pairing;

/// Holds "these observations are of these landmarks" against "they are of something else".
///
/// Where the robot is uncertain by metres, some landmark fits whatever is seen, and that it fits
/// says nothing. Two that fit together say much more: what is seen twice has the same distance on
/// the map, however far the robot is off.
pub(in crate::association) struct Evidence<'a, P> {
    pub(in crate::association) pairing: &'a P,
    /// How much likelier the pairs must be, in logarithms.
    pub(in crate::association) lead: f64,
}

impl<P> Evidence<'_, P> {
    /// Leaves out partners that are not much likelier than chance, of observations from `first` on.
    pub(in crate::association) fn drop_unsure<const M: usize>(
        &self,
        first: usize,
        partners: &mut [Option<usize>],
    ) where
        P: Pairing<M>,
    {
        let mut pairs: Vec<(usize, usize)> =
            (first..).zip(partners.iter()).filter_map(|(s, p)| p.map(|p| (s, p))).collect();
        if pairs.iter().all(|pair| self.pairing.elsewhere(pair.0) <= 0.0) {
            return;
        }
        let sure = self.sure_ones(&mut pairs);
        for (observation, partner) in (first..).zip(partners) {
            *partner = partner.filter(|landmark| sure.contains(&(observation, *landmark)));
        }
    }

    /// Takes away the pair that the others support least, until all are supported; then those that
    /// only support each other, unless they are likely together.
    fn sure_ones<const M: usize>(&self, pairs: &mut Vec<(usize, usize)>) -> Vec<(usize, usize)>
    where
        P: Pairing<M>,
    {
        loop {
            let all = self.of(pairs);
            let without = |k: usize| {
                let others: Vec<_> = without(pairs, k);
                all - self.of(&others)
            };
            let support = (0..pairs.len()).map(|k| (without(k), k));
            match support.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((least, k)) if least < self.lead => pairs.remove(k),
                _ => break,
            };
        }
        let strong = self.strong_ones(pairs);
        if self.of(pairs) - self.of(&strong) < self.lead { strong } else { pairs.clone() }
    }

    /// Pairs that are likely on their own, and those that these make likely.
    fn strong_ones<const M: usize>(&self, pairs: &[(usize, usize)]) -> Vec<(usize, usize)>
    where
        P: Pairing<M>,
    {
        let (mut strong, mut weak) = (Vec::new(), pairs.to_vec());
        loop {
            let known = self.of(&strong);
            let helped = |pair: &(usize, usize)| {
                let more: Vec<_> = strong.iter().chain([pair]).copied().collect();
                self.of(&more) - known >= self.lead
            };
            let (new, rest): (Vec<_>, Vec<_>) = weak.iter().partition(|pair| helped(pair));
            if new.is_empty() {
                return strong;
            }
            strong.extend(new);
            weak = rest;
        }
    }

    /// Logarithm of the likelihood of all pairs together over that of as many chances.
    fn of<const M: usize>(&self, pairs: &[(usize, usize)]) -> f64
    where
        P: Pairing<M>,
    {
        let mut joint = JointInnovation::<M>::default();
        let mut chance = 0.0;
        for &pair in pairs {
            if !joint.push(self.pairing, pair) {
                return f64::NEG_INFINITY;
            }
            chance += self.pairing.elsewhere(pair.0).max(f64::MIN_POSITIVE).ln();
        }
        joint.log_likelihood() - chance
    }
}

fn without(pairs: &[(usize, usize)], k: usize) -> Vec<(usize, usize)> {
    let others = pairs.iter().enumerate().filter(|(other, _)| *other != k);
    others.map(|(_, pair)| *pair).collect()
}
