//! Plots of quantities over time, as PNG files.

use super::Error;
use super::picture::Picture;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;
use std::path::Path;

const WIDTH: usize = 1400;
const TITLE_HEIGHT: usize = 56;
const PANEL_HEIGHT: usize = 270;
pub(super) const FONT: &str = "sans-serif";
const LINE_COLORS: [RGBColor; 4] = [
    RGBColor(31, 102, 173),
    RGBColor(196, 78, 34),
    RGBColor(38, 132, 84),
    RGBColor(126, 72, 160),
];

/// One quantity over time.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What is shown, and its unit (empty for a pure number).
    pub label: String,
    pub unit: String,
    /// Whether the vertical axis is logarithmic; values that are not positive are then left out.
    pub log: bool,
    /// Time in seconds and value; points that are not finite are left out.
    pub series: Vec<(f64, f64)>,
}

impl Panel {
    fn y_label(&self) -> String {
        match self.unit.as_str() {
            "" => self.label.clone(),
            unit => format!("{} in {unit}", self.label),
        }
    }
}

/// Draws the panels one below the other over a common time axis.
pub fn time_series(path: impl AsRef<Path>, title: &str, panels: &[Panel]) -> Result<(), Error> {
    register_font();
    let mut picture = Picture::new(WIDTH, TITLE_HEIGHT + panels.len() * PANEL_HEIGHT, [255; 3]);
    {
        let size = (WIDTH as u32, picture.height as u32);
        let root =
            BitMapBackend::with_buffer(picture.pixels.as_flattened_mut(), size).into_drawing_area();
        let (head, body) = root.split_vertically(TITLE_HEIGHT as u32);
        let style = (FONT, 32).into_font().color(&BLACK);
        let anchor = style.pos(Pos::new(HPos::Center, VPos::Center));
        let center = (WIDTH as i32 / 2, TITLE_HEIGHT as i32 / 2);
        head.draw_text(title, &anchor, center).map_err(plain)?;
        let times = range(panels.iter().flat_map(|p| &p.series).map(|s| s.0));
        for (i, (panel, area)) in panels
            .iter()
            .zip(body.split_evenly((panels.len(), 1)))
            .enumerate()
        {
            draw_panel(
                &area,
                panel,
                times.clone(),
                LINE_COLORS[i % LINE_COLORS.len()],
            )?;
        }
        root.present().map_err(plain)?;
    }
    picture.save(path)
}

/// Makes the font of the plots known.
pub(super) fn register_font() {
    // An error here means that another font of that name is there already, which serves as well.
    let _ =
        plotters::style::register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
}

type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

fn draw_panel(
    area: &Area<'_>,
    panel: &Panel,
    times: Range<f64>,
    color: RGBColor,
) -> Result<(), Error> {
    let drawable = |&(t, y): &(f64, f64)| t.is_finite() && y.is_finite() && (!panel.log || y > 0.0);
    let points: Vec<(f64, f64)> = panel.series.iter().copied().filter(drawable).collect();
    let values = range(points.iter().map(|p| p.1));
    let mut builder = ChartBuilder::on(area);
    builder
        .margin_left(24)
        .margin_right(30)
        .margin_top(14)
        .x_label_area_size(46)
        .y_label_area_size(110);
    // The two axes differ in type, not in what is drawn.
    macro_rules! draw {
        ($axis:expr) => {{
            let mut chart = builder.build_cartesian_2d(times, $axis).map_err(plain)?;
            chart
                .configure_mesh()
                .x_desc("time in s")
                .y_desc(panel.y_label())
                .label_style((FONT, 19))
                .axis_desc_style((FONT, 21))
                .bold_line_style(BLACK.mix(0.16))
                .light_line_style(BLACK.mix(0.04))
                .y_labels(6)
                .y_label_formatter(&|y| number(*y))
                .draw()
                .map_err(plain)?;
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(2)))
                .map_err(plain)?;
        }};
    }
    if panel.log {
        // At least two decades, so that the axis has ticks.
        let low = 10_f64.powf(values.start.max(f64::MIN_POSITIVE).log10().floor());
        let high = 10_f64
            .powf(values.end.max(low).log10().ceil())
            .max(low * 100.0);
        draw!((low..high).log_scale());
    } else {
        let margin = 0.06 * (values.end - values.start);
        draw!(values.start - margin..values.end + margin);
    }
    Ok(())
}

/// The smallest range that holds all finite values, never empty.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
    if low > high {
        0.0..1.0
    } else if low == high {
        low..low + low.abs().max(1e-6)
    } else {
        low..high
    }
}

/// A tick label: short, and never a row of zeros.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        format!("{value:.0e}")
    }
}

/// The error of the plot crate borrows the picture, so only its text can leave.
pub(super) fn plain(error: impl std::fmt::Display) -> Error {
    error.to_string().into()
}
