//! What things look like: roles, line styles and the palette.
//!
//! The palette is the one of Okabe and Ito (2008), which colour-blind readers can tell apart,
//! with its yellow darkened for white paper; the dark variants are the same hues, lighter. Six more
//! colours, which lines with dashes have, are for runs of many methods.

use std::collections::BTreeSet;

/// What a thing in a figure stands for; it decides the colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Role {
    /// Where the robot really was.
    Truth,
    /// The k-th method of a run, counted from 0. Twelve have a colour each, and from the seventh on
    /// dashes as well; then the colours begin again, with other dashes.
    Method(usize),
    /// A landmark of the map.
    Landmark,
    /// What a sensor reported.
    Measurement,
    /// The map: lines, graph edges.
    Map,
    /// What blocks the way: walls, obstacles.
    Obstacle,
    /// A threshold or an ideal to compare with.
    Reference,
}

/// How a thing is drawn: its role, and where wanted a width and dashes.
///
/// A plain [`Role`] converts into the style that suits it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    role: Role,
    dash: Dash,
    width: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Dash {
    Solid,
    Dotted,
    Dashed,
}

impl Role {
    /// A dotted line in this role's colour.
    pub fn dotted(self) -> Style {
        Style::from(self).dotted()
    }

    /// A dashed line in this role's colour.
    pub fn dashed(self) -> Style {
        Style::from(self).dashed()
    }

    /// A line of this width \[px of a figure 640 px wide\], or dots of this diameter.
    pub fn width(self, width: f64) -> Style {
        Style::from(self).width(width)
    }
}

impl From<Role> for Style {
    fn from(role: Role) -> Self {
        Style { role, dash: Dash::Solid, width: None }
    }
}

impl Style {
    /// The same, dotted.
    #[must_use]
    pub fn dotted(self) -> Self {
        let dash = Dash::Dotted;
        Style { dash, ..self }
    }

    /// The same, dashed.
    #[must_use]
    pub fn dashed(self) -> Self {
        let dash = Dash::Dashed;
        Style { dash, ..self }
    }

    /// The same with a line width, or dot diameter, within 0.1 to 20
    /// \[px of a figure 640 px wide\]. NaN leaves the width as it is.
    #[must_use]
    pub fn width(self, width: f64) -> Self {
        if width.is_nan() {
            return self;
        }
        let width = Some(width.clamp(0.1, 20.0));
        Style { width, ..self }
    }

    pub(crate) fn paint(self) -> Paint {
        Paint::of(self.role)
    }

    pub(crate) fn width_or(self, usual: f64) -> f64 {
        self.width.unwrap_or(usual)
    }

    /// The `stroke-dasharray` for a line of `width`, none for a solid line.
    pub(crate) fn dashes(self, width: f64) -> Option<String> {
        let lengths: &[f64] = match (self.dash, self.role) {
            (Dash::Dotted, _) => &[0.01, 2.6],
            (Dash::Dashed, _) => &[4.5, 3.2],
            (Dash::Solid, Role::Method(k)) => round_of_dashes(k / SOLID),
            (Dash::Solid, _) => &[],
        };
        let scaled: Vec<String> =
            lengths.iter().map(|length| crate::writer::number(length * width.max(0.7))).collect();
        (!scaled.is_empty()).then(|| scaled.join(" "))
    }
}

/// Dashes that tell methods of the same colour apart, in line widths.
fn round_of_dashes(round: usize) -> &'static [f64] {
    match round {
        0 => &[],
        1 => &[4.5, 2.8, 0.01, 2.8],
        2 => &[7.0, 3.0],
        _ => &[4.5, 2.8, 0.01, 2.8, 0.01, 2.8],
    }
}

/// A colour with its variants for light and dark surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Paint {
    pub(crate) name: &'static str,
    pub(crate) light: &'static str,
    dark: &'static str,
}

const fn paint(name: &'static str, light: &'static str, dark: &'static str) -> Paint {
    Paint { name, light, dark }
}

/// As many methods have a solid line; the next ones have dashes too.
const SOLID: usize = 6;

const METHODS: [Paint; 12] = [
    paint("m0", "#0072b2", "#4a9fe0"),
    paint("m1", "#d55e00", "#f57a3d"),
    paint("m2", "#009e73", "#2dc79a"),
    paint("m3", "#cc79a7", "#e6a0c8"),
    paint("m4", "#e69f00", "#f2b440"),
    paint("m5", "#56b4e9", "#a5dcff"),
    paint("m6", "#7a3ea8", "#b98ae6"),
    paint("m7", "#8b4a1f", "#cf9a6c"),
    paint("m8", "#b8003c", "#ff6b8e"),
    paint("m9", "#5f7a00", "#a9c43c"),
    paint("m10", "#007a87", "#3fd0d4"),
    paint("m11", "#3d4db7", "#98a4ff"),
];

impl Paint {
    pub(crate) const PAPER: Paint = paint("paper", "#ffffff", "#0f1419");
    pub(crate) const INK: Paint = paint("ink", "#1f2328", "#e8ecf0");
    pub(crate) const MUTED: Paint = paint("muted", "#59636e", "#9aa5b1");
    pub(crate) const GRID: Paint = paint("grid", "#e7eaed", "#262d36");
    pub(crate) const EDGE: Paint = paint("edge", "#b3bac2", "#4a5460");

    fn of(role: Role) -> Paint {
        match role {
            Role::Truth => Paint::INK,
            Role::Method(k) => METHODS[k % METHODS.len()],
            Role::Landmark => paint("landmark", "#3d4650", "#c3ccd6"),
            Role::Measurement => paint("measurement", "#a68a00", "#f0e442"),
            Role::Map => paint("map", "#8c959f", "#768390"),
            Role::Obstacle => paint("obstacle", "#59636e", "#909dab"),
            Role::Reference => Paint::MUTED,
        }
    }
}

/// The style sheet: dark colours for the paints in use, where the viewer asks for dark.
pub(crate) fn style_sheet(paints: &BTreeSet<Paint>) -> String {
    let mut variables = String::new();
    let mut classes = String::new();
    for Paint { name, dark, .. } in paints {
        variables.push_str(&format!("--loc-{name}:{dark};"));
        classes.push_str(&format!(".loc-f-{name}{{fill:var(--loc-{name})}}"));
        classes.push_str(&format!(".loc-s-{name}{{stroke:var(--loc-{name})}}\n"));
    }
    format!(
        "<style>.loc-figure{{color-scheme:light dark}}\n\
         @media (prefers-color-scheme:dark){{\n.loc-figure{{{variables}}}\n{classes}\
         .loc-image{{filter:invert(.92) hue-rotate(180deg)}}\n}}</style>\n"
    )
}
