//! The page that shows a run: one file, without network.
//!
//! A run that was filmed gets a player: the map with paths, scan, particles, ellipses and clusters
//! at any moment, and the errors over time beside it, linked to it. Its script and its style are
//! files beside this one; its numbers are packed into the page.

use super::figures::FigureFile;
use super::table::{COLUMNS, cells, table};
use crate::metrics::Summary;
use crate::record::Run;
use player::Player;
use std::fmt::Write;

mod player;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("player.js");
const CONTROLS: &str = include_str!("player.html");

/// What makes a report again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Made<'a> {
    /// The command.
    pub command: &'a str,
    /// The text of the scenario that it names, before what `--set` and `--seed` change; `None` for
    /// a recording.
    pub scenario: Option<&'a str>,
}

impl<'a> From<&'a str> for Made<'a> {
    fn from(command: &'a str) -> Self {
        Made { command, scenario: None }
    }
}

/// What a report shows.
#[derive(Debug, Clone, Copy)]
pub struct Report<'a> {
    /// The run.
    pub run: &'a Run,
    /// Its figures.
    pub summary: &'a Summary,
    /// Its heading.
    pub title: &'a str,
    /// What makes it again.
    pub made: Made<'a>,
}

impl Report<'_> {
    /// The page, with figures below the player.
    pub fn html(&self, figures: &[FigureFile]) -> String {
        let summary = self.summary;
        let mut body = format!("<p class=\"lead\">{}</p>\n", escape(&lead(summary)));
        if let Some(player) = Player::of(self.run) {
            body.push_str(CONTROLS);
            body.push_str(&script(&player));
        }
        body.push_str("<h2>Figures of merit</h2>\n");
        body.push_str(&html_table(summary));
        for note in &summary.notes {
            // Writing to a String cannot fail.
            let _ = writeln!(body, "<p class=\"lead\">Note: {}</p>", escape(note));
        }
        body.push_str("<h2>Figures</h2>\n");
        body.push_str(&drawings(figures));
        body.push_str(&again(self.made, summary.seed, Some(&table(summary))));
        page(self.title, &body)
    }
}

/// A page with a text, figures and what makes it again.
pub(crate) fn plain(text: &str, title: &str, made: Made<'_>, figures: &[FigureFile]) -> String {
    let body =
        format!("<pre>{}</pre>\n{}{}", escape(text), drawings(figures), again(made, None, None));
    page(title, &body)
}

fn page(title: &str, body: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}</body>\n</html>\n"
    )
}

/// Where and when, in a line.
fn lead(summary: &Summary) -> String {
    let way = summary.distance_m.map_or(String::new(), |way| format!("{way:.1} m in "));
    let seed = summary.seed.map_or(String::new(), |seed| format!(", seed {seed}"));
    format!("{}: {way}{:.1} s{seed}", summary.source, summary.duration_s)
}

/// The numbers of the player with its script.
fn script(player: &Player) -> String {
    // `</script>` inside a string would end the element. Numbers and names always serialize.
    let json = serde_json::to_string(player).unwrap_or_default().replace('<', "\\u003c");
    format!(
        "<script type=\"application/json\" id=\"run\">{json}</script>\n<script>\n{SCRIPT}</script>\n"
    )
}

fn html_table(summary: &Summary) -> String {
    let mut html = String::from("<div class=\"wide\"><table>\n<tr><th scope=\"col\">method</th>");
    for (column, _) in COLUMNS {
        let _ = write!(html, "<th scope=\"col\">{}</th>", escape(column));
    }
    html.push_str("</tr>\n");
    for (name, method) in &summary.methods {
        let _ = write!(html, "<tr><td>{}</td>", escape(name));
        for cell in cells(method) {
            let _ = write!(html, "<td>{}</td>", escape(&cell));
        }
        html.push_str("</tr>\n");
    }
    html + "</table></div>\n"
}

fn drawings(figures: &[FigureFile]) -> String {
    let mut html = String::new();
    for figure in figures {
        // An SVG inside a page goes without the XML declaration of a file.
        let svg = figure.svg.find("<svg").map_or("", |start| &figure.svg[start..]);
        let _ = writeln!(
            html,
            "<figure role=\"img\" aria-label=\"{0}\">\n{svg}\n<figcaption>{0}</figcaption></figure>",
            escape(&figure.caption)
        );
    }
    html
}

fn again(made: Made<'_>, seed: Option<u64>, text: Option<&str>) -> String {
    let seed = seed.map_or(String::new(), |seed| format!("   # seed {seed}"));
    let text = text.map_or(String::new(), |text| format!("\n\n{text}"));
    let made_by = escape(&format!("{}{seed}{text}", made.command));
    let scenario = made.scenario.map_or(String::new(), |scenario| {
        format!(
            "<details>\n<summary>The scenario, before what --set and --seed change</summary>\n\
             <pre>{}</pre>\n</details>\n",
            escape(scenario.trim_end())
        )
    });
    format!("<h2>Made by</h2>\n<pre>{made_by}</pre>\n{scenario}")
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
