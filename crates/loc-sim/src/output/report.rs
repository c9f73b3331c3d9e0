//! The page that shows a run: one file, without network.

use super::figures::FigureFile;
use super::table::table;
use crate::metrics::Summary;
use std::fmt::Write;

const STYLE: &str = "
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 60rem; padding: 1rem; }
pre { overflow-x: auto; padding: .75rem; border: 1px solid #8886; border-radius: .4rem; }
figure { margin: 2rem 0; }
figure svg { display: block; width: 100%; height: auto; }
figcaption { opacity: .75; font-size: .9rem; }
";

/// The report of a run as HTML, with the command that makes it again.
pub fn report(summary: &Summary, title: &str, command: &str, figures: &[FigureFile]) -> String {
    page(&table(summary), title, command, figures)
}

/// A page with a text, figures and the command that makes it again.
pub(crate) fn page(text: &str, title: &str, command: &str, figures: &[FigureFile]) -> String {
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{0}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n\
         <pre>{1}</pre>\n",
        escape(title),
        escape(text),
    );
    for figure in figures {
        // An SVG inside a page goes without the XML declaration of a file.
        let svg = figure.svg.find("<svg").map_or("", |start| &figure.svg[start..]);
        // Writing to a String cannot fail.
        let _ = writeln!(
            html,
            "<figure role=\"img\" aria-label=\"{0}\">\n{svg}\n<figcaption>{0}</figcaption></figure>",
            escape(figure.caption)
        );
    }
    let _ = write!(html, "<p>Made by</p>\n<pre>{}</pre>\n</body>\n</html>\n", escape(command));
    html
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
