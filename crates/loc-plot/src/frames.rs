//! Small scenes side by side: the same place at several times.

use crate::axis::{Area, TICK_SIZE};
use crate::pictures::{ColorBar, draw_bar};
use crate::scene::{Backdrop, Scene, draw_image, draw_item, legend_of};
use crate::style::Paint;
use crate::text::Anchor;
use crate::view::{Bounds, View};
use crate::writer::{Element, Writer};
use crate::{WIDTH, header, text};

const LEFT: f64 = 14.0;
const GAP: f64 = 10.0;
/// Height of a caption \[px\].
const CAPTION: f64 = 19.0;
/// Room around the content where there is no backdrop, as a share of its size.
const MARGIN: f64 = 0.05;

/// Small [`Scene`]s in rows, all with the same view, over the same backdrop: what happened one
/// after the other. Titles of the single scenes are not shown; a scene with a backdrop of its own
/// has that instead.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    title: String,
    subtitle: String,
    backdrop: Option<Backdrop>,
    frames: Vec<(String, Scene)>,
    columns: Option<usize>,
    bar: Option<ColorBar>,
}

impl Frames {
    /// A figure without frames.
    pub fn new(title: impl Into<String>) -> Self {
        Frames { title: title.into(), ..Frames::default() }
    }

    /// A line under the title, in smaller letters.
    #[must_use]
    pub fn subtitle(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// An image under every frame; it is in the file once, and every frame shows just its extent.
    #[must_use]
    pub fn backdrop(mut self, backdrop: Backdrop) -> Self {
        self.backdrop = Some(backdrop).filter(Backdrop::is_valid);
        self
    }

    /// Adds a scene with a caption above it.
    #[must_use]
    pub fn frame(mut self, caption: impl Into<String>, scene: Scene) -> Self {
        self.frames.push((caption.into(), scene));
        self
    }

    /// So many frames side by side, at least 1; as suits their shape where left out.
    #[must_use]
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = Some(columns.max(1));
        self
    }

    /// The meaning of colours, below all frames.
    #[must_use]
    pub fn bar(mut self, bar: ColorBar) -> Self {
        self.bar = Some(bar);
        self
    }

    /// The SVG file.
    pub fn render(&self) -> String {
        let mut writer = Writer::default();
        let items = self.frames.iter().flat_map(|(_, scene)| &scene.items);
        let mut top =
            header::draw(&mut writer, &self.title, &self.subtitle, &legend_of(items)) + 6.0;
        let bounds = self.bounds();
        let (width, height) = bounds.size();
        let suited = || columns(width / height, self.frames.len());
        let columns = self.columns.unwrap_or_else(suited);
        let frame_width = (WIDTH - 2.0 * LEFT - (columns - 1) as f64 * GAP) / columns as f64;
        let frame_height = frame_width * (height / width).clamp(0.2, 2.0);
        for (k, (caption, scene)) in self.frames.iter().enumerate() {
            let left = LEFT + (k % columns) as f64 * (frame_width + GAP);
            let area = Area { left, top: top + CAPTION, width: frame_width, height: frame_height };
            self.draw_frame(&mut writer, k, &View::exactly(bounds, area), caption, scene);
            if (k + 1).is_multiple_of(columns) || k + 1 == self.frames.len() {
                top = area.bottom() + 7.0;
            }
        }
        if let Some(bar) = &self.bar {
            top = draw_bar(&mut writer, bar, LEFT, top + 6.0, WIDTH - 2.0 * LEFT, true);
        }
        writer.finish(&self.title, top + 6.0)
    }

    fn draw_frame(&self, writer: &mut Writer, k: usize, view: &View, caption: &str, scene: &Scene) {
        let area = &view.area;
        let caption = text::shorten(caption, TICK_SIZE, area.width);
        let at = (area.left, area.top - 5.0);
        writer.text(text::element(at, TICK_SIZE, Anchor::Start, Paint::INK), &caption);
        if let Some(own) = scene.backdrop.as_ref().filter(|image| image.is_valid()) {
            draw_image(writer, view, own, None);
        } else if let Some(backdrop) = &self.backdrop {
            // Equal names mean equal images, also among the figures of one page.
            let id = format!("loc-image-{:x}", hash(&backdrop.data_uri));
            if k == 0 {
                let at_origin = Area { left: 0.0, top: 0.0, ..*area };
                let origin = View::exactly(self.bounds(), at_origin);
                writer.open(Element::new("defs"));
                draw_image(writer, &origin, backdrop, Some(&id));
                writer.close();
            }
            let image = Element::new("use").class("loc-image").attr("href", &format!("#{id}"));
            writer.add(image.num("x", area.left).num("y", area.top));
        }
        area.open_clip(writer, 0.0);
        for item in &scene.items {
            draw_item(writer, view, item);
        }
        writer.close();
        area.draw_grid(writer, &view.x, &view.y);
    }

    /// What every frame shows.
    fn bounds(&self) -> Bounds {
        let own = || self.frames.iter().find_map(|(_, scene)| scene.backdrop.as_ref());
        let image = self.backdrop.as_ref().or_else(own).filter(|image| image.is_valid());
        if let Some(Backdrop { min, max, .. }) = image {
            return Bounds { min: *min, max: *max };
        }
        let all = self.frames.iter().filter_map(|(_, scene)| Bounds::of(scene));
        let nothing = Bounds { min: (-1.0, -1.0), max: (1.0, 1.0) };
        all.reduce(Bounds::union).map_or(nothing, |bounds| bounds.with_margin(MARGIN))
    }
}

/// So many frames side by side that they are neither tiny nor a long column.
fn columns(aspect: f64, count: usize) -> usize {
    let wanted = if aspect > 2.5 { 2 } else { 3 };
    wanted.min(count.max(1))
}

/// The 64-bit FNV-1a hash.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}
