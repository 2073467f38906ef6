//! Charts of points and lines over two axes, either of which may be logarithmic, as PNG files.

use super::Error;
use super::picture::Picture;
use super::plot::{FONT, number, plain, register_font};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

const WIDTH: i32 = 1200;
const HEIGHT: i32 = 680;
/// Edges of the plane of the axes, pixels.
const LEFT: i32 = 120;
const RIGHT: i32 = WIDTH - 280;
const TOP: i32 = 84;
const BOTTOM: i32 = HEIGHT - 84;
/// Height of a line of text beside the marks, pixels.
const LINE: i32 = 20;
/// Half the size of a mark, pixels.
const MARK: i32 = 6;

/// An axis from `low` to `high`; logarithmic ones must be positive.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it shows, with its unit.
    pub label: String,
    pub low: f64,
    pub high: f64,
    pub is_log: bool,
}

/// How a point is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    Circle,
    Triangle,
    Square,
    Cross,
}

/// Points of one kind.
#[derive(Clone, Debug)]
pub struct Series {
    /// In the legend, if not empty.
    pub name: String,
    pub color: [u8; 3],
    pub mark: Option<Mark>,
    pub is_filled: bool,
    /// Width of the line through the points, pixels; 0 for none.
    pub line: u32,
    pub points: Vec<(f64, f64)>,
}

/// A word at a point.
#[derive(Clone, Debug)]
pub struct Note {
    pub at: (f64, f64),
    pub text: String,
    /// With a ring around the point.
    pub is_ringed: bool,
}

/// All that a picture shows.
#[derive(Clone, Debug)]
pub struct Chart {
    pub title: String,
    /// A smaller line under the title.
    pub caption: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    /// The first ones have the first choice of a place.
    pub notes: Vec<Note>,
    /// A dashed level line and what it means.
    pub level: Option<(f64, String)>,
}

impl Axis {
    /// A logarithmic axis that holds all positive `values`, from and to a power of ten.
    pub fn decades(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = range(values);
        let low = low.log10().floor();
        let high = high.log10().ceil().max(low + 1.0);
        Self {
            label: label.into(),
            low: 10_f64.powf(low),
            high: 10_f64.powf(high),
            is_log: true,
        }
    }

    /// A logarithmic axis that holds all positive `values` with some room, with ends of one digit.
    pub fn tight(label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = range(values);
        let decade = |v: f64| 10_f64.powf(v.log10().floor());
        let (a, b) = (0.8 * low, 1.25 * high);
        Self {
            label: label.into(),
            low: (a / decade(a)).floor() * decade(a),
            high: (b / decade(b)).ceil() * decade(b),
            is_log: true,
        }
    }

    /// Place of a value along the axis, 0 to 1; values beyond an end are put on it.
    fn place(&self, value: f64) -> f64 {
        let map = |v: f64| if self.is_log { v.log10() } else { v };
        let share = (map(value) - map(self.low)) / (map(self.high) - map(self.low));
        share.clamp(0.0, 1.0)
    }

    /// Values with a line across, and whether they have a label.
    fn ticks(&self) -> Vec<(f64, bool)> {
        if !self.is_log {
            let at = |i: u8| self.low + 0.1 * f64::from(i) * (self.high - self.low);
            return (0..=10).map(|i| (at(i), i % 2 == 0)).collect();
        }
        let (first, last) = (self.low.log10().floor(), self.high.log10().ceil());
        let is_short = self.high / self.low < 101.0;
        let decades = (first as i32..=last as i32).map(|k| 10_f64.powi(k));
        let ticks = decades.flat_map(|decade| {
            let labelled = move |i: i32| i == 1 || is_short && (i == 2 || i == 5);
            (1..10).map(move |i| (f64::from(i) * decade, labelled(i)))
        });
        let (low, high) = (0.999 * self.low, 1.001 * self.high);
        ticks.filter(|(v, _)| (low..=high).contains(v)).collect()
    }
}

/// Least and largest of the positive finite values; 1 and 1 if there is none.
fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let usable = values.into_iter().filter(|v| v.is_finite() && *v > 0.0);
    let found = usable.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
    if found.1 > 0.0 { found } else { (1.0, 1.0) }
}

type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// A rectangle that is taken: left, top, right, bottom, pixels.
type Taken = [i32; 4];

/// Writes the chart to a PNG file.
pub fn draw(path: impl AsRef<Path>, chart: &Chart) -> Result<(), Error> {
    register_font();
    let mut picture = Picture::new(WIDTH as usize, HEIGHT as usize, [255; 3]);
    {
        let size = (WIDTH as u32, HEIGHT as u32);
        let pixels = picture.pixels.as_flattened_mut();
        let area = BitMapBackend::with_buffer(pixels, size).into_drawing_area();
        draw_axes(&area, chart)?;
        draw_level(&area, chart)?;
        for series in &chart.series {
            draw_series(&area, chart, series)?;
        }
        draw_notes(&area, chart)?;
        draw_legend(&area, chart)?;
        area.present().map_err(plain)?;
    }
    picture.save(path)
}

fn pixel(chart: &Chart, (x, y): (f64, f64)) -> (i32, i32) {
    let along =
        |share: f64, from: i32, to: i32| from + (share * f64::from(to - from)).round() as i32;
    (
        along(chart.x.place(x), LEFT, RIGHT),
        along(chart.y.place(y), BOTTOM, TOP),
    )
}

fn text(
    area: &Area<'_>,
    text: &str,
    size: i32,
    at: (i32, i32),
    (h, v): (HPos, VPos),
) -> Result<(), Error> {
    let style = (FONT, size).into_font().color(&BLACK).pos(Pos::new(h, v));
    area.draw_text(text, &style, at).map_err(plain)
}

fn line(
    area: &Area<'_>,
    points: Vec<(i32, i32)>,
    style: impl Into<ShapeStyle>,
) -> Result<(), Error> {
    area.draw(&PathElement::new(points, style)).map_err(plain)
}

fn draw_axes(area: &Area<'_>, chart: &Chart) -> Result<(), Error> {
    let middle = (LEFT + RIGHT) / 2;
    text(area, &chart.title, 30, (LEFT, 14), (HPos::Left, VPos::Top))?;
    text(
        area,
        &chart.caption,
        19,
        (LEFT, 50),
        (HPos::Left, VPos::Top),
    )?;
    let faint = |is_labelled: bool| BLACK.mix(if is_labelled { 0.22 } else { 0.07 });
    for (value, is_labelled) in chart.x.ticks() {
        let (x, _) = pixel(chart, (value, chart.y.low));
        line(area, vec![(x, TOP), (x, BOTTOM)], faint(is_labelled))?;
        if is_labelled {
            text(
                area,
                &number(value),
                19,
                (x, BOTTOM + 8),
                (HPos::Center, VPos::Top),
            )?;
        }
    }
    for (value, is_labelled) in chart.y.ticks() {
        let (_, y) = pixel(chart, (chart.x.low, value));
        line(area, vec![(LEFT, y), (RIGHT, y)], faint(is_labelled))?;
        if is_labelled {
            text(
                area,
                &number(value),
                19,
                (LEFT - 10, y),
                (HPos::Right, VPos::Center),
            )?;
        }
    }
    let frame = [(LEFT, TOP), (RIGHT, BOTTOM)];
    area.draw(&Rectangle::new(frame, BLACK)).map_err(plain)?;
    text(
        area,
        &chart.x.label,
        22,
        (middle, HEIGHT - 18),
        (HPos::Center, VPos::Bottom),
    )?;
    let turned = (FONT, 22)
        .into_font()
        .transform(FontTransform::Rotate270)
        .color(&BLACK)
        .pos(Pos::new(HPos::Center, VPos::Top));
    let at = (24, (TOP + BOTTOM) / 2);
    area.draw_text(&chart.y.label, &turned, at).map_err(plain)
}

fn draw_level(area: &Area<'_>, chart: &Chart) -> Result<(), Error> {
    let Some((value, name)) = &chart.level else {
        return Ok(());
    };
    let (_, y) = pixel(chart, (chart.x.low, *value));
    for x in (LEFT..RIGHT).step_by(14) {
        line(area, vec![(x, y), ((x + 7).min(RIGHT), y)], BLACK.mix(0.6))?;
    }
    text(
        area,
        name,
        17,
        (RIGHT - 8, y - 3),
        (HPos::Right, VPos::Bottom),
    )
}

fn draw_series(area: &Area<'_>, chart: &Chart, series: &Series) -> Result<(), Error> {
    let [r, g, b] = series.color;
    let color = RGBColor(r, g, b);
    let points: Vec<_> = series.points.iter().map(|&p| pixel(chart, p)).collect();
    if series.line > 0 {
        line(area, points.clone(), color.stroke_width(series.line))?;
    }
    for at in points {
        draw_mark(area, series, at)?;
    }
    Ok(())
}

fn draw_mark(area: &Area<'_>, series: &Series, (x, y): (i32, i32)) -> Result<(), Error> {
    let [r, g, b] = series.color;
    let color = RGBColor(r, g, b);
    let style = if series.is_filled {
        color.filled()
    } else {
        color.stroke_width(2)
    };
    let outline = |corners: &[(i32, i32)]| {
        let corners: Vec<_> = corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect();
        if series.is_filled {
            area.draw(&Polygon::new(corners, style)).map_err(plain)
        } else {
            let closed = corners.iter().chain(corners.first()).copied().collect();
            line(area, closed, style)
        }
    };
    match series.mark {
        None => Ok(()),
        Some(Mark::Circle) => area.draw(&Circle::new((x, y), MARK, style)).map_err(plain),
        Some(Mark::Triangle) => outline(&[(-7, 5), (7, 5), (0, -8)]),
        Some(Mark::Square) => outline(&[(-5, -5), (5, -5), (5, 5), (-5, 5)]),
        Some(Mark::Cross) => {
            line(
                area,
                vec![(x - 5, y - 5), (x + 5, y + 5)],
                color.stroke_width(2),
            )?;
            line(
                area,
                vec![(x - 5, y + 5), (x + 5, y - 5)],
                color.stroke_width(2),
            )
        }
    }
}

/// Rings, and words near their points where they cover neither a mark nor each other; a word without room is left out.
fn draw_notes(area: &Area<'_>, chart: &Chart) -> Result<(), Error> {
    let marked = chart.series.iter().filter(|s| s.mark.is_some());
    let mut taken: Vec<Taken> = marked
        .flat_map(|s| &s.points)
        .map(|&p| {
            let (x, y) = pixel(chart, p);
            [x - MARK, y - MARK, x + MARK, y + MARK]
        })
        .collect();
    if let Some((value, _)) = chart.level {
        let (_, y) = pixel(chart, (chart.x.low, value));
        taken.push([RIGHT - 4 * LINE, y - LINE, RIGHT, y]);
    }
    for note in &chart.notes {
        let (x, y) = pixel(chart, note.at);
        if note.is_ringed {
            let ring = BLACK.stroke_width(2);
            area.draw(&Circle::new((x, y), 2 * MARK, ring))
                .map_err(plain)?;
        }
        let style = (FONT, 18).into_font().color(&BLACK);
        let (width, _) = area.estimate_text_size(&note.text, &style).map_err(plain)?;
        let gap = if note.is_ringed { 3 } else { 2 } * MARK + 2;
        let Some(place) = free_place((x, y), gap, width as i32, &taken) else {
            continue;
        };
        taken.push(place);
        text(
            area,
            &note.text,
            18,
            (place[0], place[1]),
            (HPos::Left, VPos::Top),
        )?;
        // Words that had to go away from their point are tied to it.
        let nearest = (x.clamp(place[0], place[2]), y.clamp(place[1], place[3]));
        let away = (nearest.0 - x).abs().max((nearest.1 - y).abs());
        if away > 3 * MARK {
            line(area, vec![(x, y), nearest], BLACK.mix(0.5))?;
        }
    }
    Ok(())
}

/// A place for a word of `width`, `gap` or little more from a point.
fn free_place((x, y): (i32, i32), gap: i32, width: i32, taken: &[Taken]) -> Option<Taken> {
    let away = [gap, 2 * gap, 3 * gap];
    let places = away.into_iter().flat_map(|gap| {
        let (right, left, middle) = (x + gap, x - gap - width, x - width / 2);
        let (above, below, beside) = (y - gap - LINE, y + gap, y - LINE / 2);
        [
            (right, beside),
            (right, above + LINE / 2),
            (right, below - LINE / 2),
            (middle, above),
            (middle, below),
            (left, beside),
            (left, above + LINE / 2),
            (left, below - LINE / 2),
        ]
    });
    let mut rectangles = places.map(|(x, y)| [x, y, x + width, y + LINE]);
    rectangles.find(|p| {
        let is_inside = p[0] > LEFT && p[2] < RIGHT && p[1] > TOP && p[3] < BOTTOM;
        let overlaps = |q: &Taken| p[0] < q[2] && q[0] < p[2] && p[1] < q[3] && q[1] < p[3];
        is_inside && !taken.iter().any(overlaps)
    })
}

fn draw_legend(area: &Area<'_>, chart: &Chart) -> Result<(), Error> {
    let named = chart.series.iter().filter(|s| !s.name.is_empty());
    for (i, series) in (0_i32..).zip(named) {
        let (x, y) = (RIGHT + 34, TOP + 16 + 28 * i);
        let [r, g, b] = series.color;
        if series.line > 0 {
            let style = RGBColor(r, g, b).stroke_width(series.line);
            line(area, vec![(x - 16, y), (x + 16, y)], style)?;
        }
        draw_mark(area, series, (x, y))?;
        text(
            area,
            &series.name,
            19,
            (x + 24, y),
            (HPos::Left, VPos::Center),
        )?;
    }
    Ok(())
}
