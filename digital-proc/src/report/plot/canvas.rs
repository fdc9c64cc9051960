//! Between plotters and the page: a frame with axes, and roles in place of colours.
//!
//! plotters lays out and writes the SVG on an integer grid of tenths of a pixel. Every
//! stroke is drawn in a marker colour that stands for a role; one pass over the finished
//! text turns it into a `class`, which the page's style sheet colours.

use maud::{Markup, PreEscaped};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::STYLES;
use super::axis::FittedAxis;
use super::line_chart::Size;

/// Drawing units a pixel.
pub(super) const UNITS: i32 = 10;
/// Mean width of a character at the labels' size, in units.
pub(super) const CHARACTER: i32 = 68;

/// What a stroke or a text is, which is all the drawing says about its looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Axis,
    Grid,
    MinorGrid,
    TickText,
    AxisTitle,
    Title,
    LegendText,
    Limit,
    LimitText,
    Mark,
    MarkText,
    Line(usize),
    Marker(usize),
    Bar(usize),
}

impl Role {
    /// The marker colour: red 1 says "a role", green which, blue the style's number.
    fn colour(self) -> RGBColor {
        let (kind, style) = match self {
            Role::Axis => (0, 0),
            Role::Grid => (1, 0),
            Role::MinorGrid => (2, 0),
            Role::TickText => (3, 0),
            Role::AxisTitle => (4, 0),
            Role::Title => (5, 0),
            Role::LegendText => (6, 0),
            Role::Limit => (7, 0),
            Role::LimitText => (8, 0),
            Role::Mark => (9, 0),
            Role::MarkText => (10, 0),
            Role::Line(style) => (11, style % STYLES),
            Role::Marker(style) => (12, style % STYLES),
            Role::Bar(style) => (13, style % STYLES),
        };
        RGBColor(1, kind, style as u8)
    }

    /// The class that the style sheet knows for a marker colour `#01KKSS`.
    fn class(hex: &str) -> Option<String> {
        const NAMES: [&str; 14] =
            ["ax", "gr", "gm", "tt", "at", "ti", "lg", "li", "lt", "mk", "mt", "l", "m", "b"];
        let hex = hex.strip_prefix("#01")?;
        let kind = usize::from_str_radix(hex.get(..2)?, 16).ok()?;
        let style = u8::from_str_radix(hex.get(2..4)?, 16).ok()?;
        let name = *NAMES.get(kind)?;
        Some(if kind >= 11 { format!("{name}{style}") } else { name.to_owned() })
    }

    fn stroke(self) -> ShapeStyle {
        self.colour().stroke_width(1)
    }
}

/// One entry of a legend.
pub(super) struct Key {
    pub(super) name: String,
    pub(super) line: Option<usize>,
    pub(super) marker: Option<usize>,
    pub(super) bar: Option<usize>,
}

/// The plotting surface inside the axes.
pub(super) struct Canvas<'a> {
    root: DrawingArea<SVGBackend<'a>, Shift>,
    x: (f64, f64),
    y: (f64, f64),
    /// Left, top, right, bottom of the plotting area, in units.
    pub(super) area: (i32, i32, i32, i32),
}

impl Canvas<'_> {
    /// Mapped coordinates to units; far outside stays within a few million units.
    pub(super) fn at(&self, x: f64, y: f64) -> (i32, i32) {
        let (left, top, right, bottom) = self.area;
        let place = |v: f64, (low, high): (f64, f64), from: i32, to: i32| {
            let share = ((v - low) / (high - low)).clamp(-300.0, 300.0);
            (f64::from(from) + share * f64::from(to - from)).round() as i32
        };
        (place(x, self.x, left, right), place(y, self.y, bottom, top))
    }

    // Writing to a String cannot fail, hence the ignored results below.
    pub(super) fn path(&self, points: Vec<(i32, i32)>, role: Role) {
        let _ = self.root.draw(&PathElement::new(points, role.stroke()));
    }

    pub(super) fn bar(&self, from: (i32, i32), to: (i32, i32), style: usize) {
        let style = Role::Bar(style).colour().filled();
        let _ = self.root.draw(&Rectangle::new([from, to], style));
    }

    pub(super) fn text(&self, text: &str, at: (i32, i32), role: Role, h: HPos, v: VPos) {
        let style = text_style(role).pos(Pos::new(h, v));
        let _ = self.root.draw_text(text, &style, at);
    }

    /// A hollow marker whose shape belongs to its style.
    pub(super) fn marker(&self, (x, y): (i32, i32), style: usize) {
        let fill = Role::Marker(style).colour().filled();
        let shape: &[(i32, i32)] = match style % 4 {
            0 => {
                let _ = self.root.draw(&Circle::new((x, y), 36, fill));
                return;
            }
            1 => &[(-34, -34), (34, -34), (34, 34), (-34, 34)],
            2 => &[(0, -44), (42, 32), (-42, 32)],
            _ => &[(0, -46), (46, 0), (0, 46), (-46, 0)],
        };
        let corners: Vec<(i32, i32)> = shape.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
        let _ = self.root.draw(&Polygon::new(corners, fill));
    }
}

fn text_style(role: Role) -> TextStyle<'static> {
    // The size serves plotters' own layout only; the style sheet decides.
    let mut style = TextStyle::from(("sans-serif", 150).into_font());
    style.color = role.colour().to_backend_color();
    style
}

/// A figure with a title, a legend and two axes; `draw` fills the plotting area, above
/// which `headroom` units are left free.
pub(super) fn frame(
    title: &str,
    size: Size,
    x: &FittedAxis,
    y: &FittedAxis,
    keys: &[Key],
    headroom: i32,
    draw: impl FnOnce(&Canvas<'_>),
) -> Markup {
    let (width, height) = (i32::from(size.width) * UNITS, i32::from(size.height) * UNITS);
    let left = 300 + y.widest() as i32 * CHARACTER + 60;
    let right = width - 160;
    let (rows, placed) = lay_out_legend(keys, left, right);
    let title_height = if title.is_empty() { 60 } else { 300 };
    let top = title_height + rows * 200 + 60 + headroom;
    let bottom = height - 450;
    let mut svg = String::with_capacity(16_384);
    {
        let root =
            SVGBackend::with_string(&mut svg, (width as u32, height as u32)).into_drawing_area();
        let chart = ChartBuilder::on(&root)
            .margin_top(top)
            .margin_right(width - right)
            .x_label_area_size(height - bottom)
            .y_label_area_size(left)
            .build_cartesian_2d(x.clone(), y.clone());
        if let Ok(mut chart) = chart {
            let _ = chart
                .configure_mesh()
                .axis_style(Role::Axis.stroke())
                .bold_line_style(Role::Grid.stroke())
                .light_line_style(Role::MinorGrid.stroke())
                .label_style(text_style(Role::TickText))
                .axis_desc_style(text_style(Role::AxisTitle))
                .set_all_tick_mark_size(40)
                .x_desc(x.title.as_str())
                .y_desc(y.title.as_str())
                .draw();
        }
        let canvas = Canvas {
            root,
            x: (x.low, x.high),
            y: (y.low, y.high),
            area: (left, top, right, bottom),
        };
        if !title.is_empty() {
            canvas.text(title, (left, 60), Role::Title, HPos::Left, VPos::Top);
        }
        for (key, (x0, row)) in keys.iter().zip(placed) {
            let y0 = title_height + row * 200 + 60;
            if let Some(style) = key.line {
                canvas.path(vec![(x0, y0), (x0 + 360, y0)], Role::Line(style));
            }
            if let Some(style) = key.marker {
                canvas.marker((x0 + 180, y0), style);
            }
            if let Some(style) = key.bar {
                canvas.bar((x0 + 100, y0 - 60), (x0 + 260, y0 + 60), style);
            }
            canvas.text(&key.name, (x0 + 430, y0), Role::LegendText, HPos::Left, VPos::Center);
        }
        draw(&canvas);
        let _ = canvas.root.present();
    }
    PreEscaped(with_classes(&svg, title))
}

/// Rows of the legend, and the place of each entry: left edge and row.
fn lay_out_legend(keys: &[Key], left: i32, right: i32) -> (i32, Vec<(i32, i32)>) {
    let (mut x, mut row) = (left, 0);
    let mut places = Vec::with_capacity(keys.len());
    for key in keys {
        let width = 430 + key.name.chars().count() as i32 * CHARACTER + 220;
        if x > left && x + width > right {
            x = left;
            row += 1;
        }
        places.push((x, row));
        x += width;
    }
    (if keys.is_empty() { 0 } else { row + 1 }, places)
}

/// Puts classes for marker colours, drops attributes that the style sheet decides, and
/// makes the root element scale with the page.
fn with_classes(svg: &str, title: &str) -> String {
    let mut out = String::with_capacity(svg.len());
    let mut lines = svg.lines();
    if let Some(root) = lines.next() {
        let view = attribute(root, "viewBox").unwrap_or("0 0 1 1");
        let width = attribute(root, "width").and_then(|w| w.parse::<u32>().ok());
        let name: Markup = maud::html! { (title) };
        out.push_str(&format!(
            "<svg class=\"chart\" viewBox=\"{view}\" role=\"img\" aria-label=\"{}\" style=\"max-width:{}px\">",
            name.into_string(),
            width.unwrap_or(7_200) / UNITS as u32
        ));
    }
    for line in lines {
        let mut rest = line;
        // Attributes end with `"`; text lines hold none (quotes are escaped).
        while let Some(start) = rest.find("=\"") {
            let name_start = rest[..start].rfind(' ').map_or(0, |space| space + 1);
            let Some(length) = rest[start + 2..].find('"') else {
                break;
            };
            let (name, value) = (&rest[name_start..start], &rest[start + 2..start + 2 + length]);
            out.push_str(rest[..name_start].trim_end_matches(' '));
            match (name, Role::class(value)) {
                ("fill" | "stroke", Some(class)) => {
                    out.push_str(" class=\"");
                    out.push_str(&class);
                    out.push('"');
                }
                ("opacity" | "stroke-width" | "font-family" | "font-size", _)
                | ("stroke", None) => {}
                _ => {
                    out.push(' ');
                    out.push_str(&rest[name_start..start + 2]);
                    out.push_str(value.trim_end());
                    out.push('"');
                }
            }
            rest = &rest[start + 3 + length..];
        }
        out.push_str(rest);
    }
    out
}

fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    let start = element.find(&format!(" {name}=\""))? + name.len() + 3;
    let length = element[start..].find('"')?;
    Some(&element[start..start + length])
}
