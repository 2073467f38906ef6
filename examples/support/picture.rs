//! `Picture`: RGB pixels, text on them, PNG files, contact sheets.

use super::Error;
use ab_glyph::{Font, FontRef, ScaleFont};
use epaint_default_fonts::UBUNTU_LIGHT;
use std::path::Path;

/// An 8-bit sRGB picture, rows from top to bottom.
#[derive(Clone, Debug)]
pub struct Picture {
    pub width: usize,
    pub height: usize,
    /// Red, green, blue of each pixel.
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// A picture of one color.
    pub fn new(width: usize, height: usize, color: [u8; 3]) -> Self {
        let pixels = vec![color; width * height];
        Self {
            width,
            height,
            pixels,
        }
    }

    /// Writes a PNG file; folders on the way are made.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let write = || -> Result<(), Error> {
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)?;
            }
            let file = std::io::BufWriter::new(std::fs::File::create(path)?);
            let mut encoder = png::Encoder::new(file, self.width as u32, self.height as u32);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(self.pixels.as_flattened())?;
            Ok(writer.finish()?)
        };
        write().map_err(|e| format!("cannot write {}: {e}", path.display()).into())
    }

    /// Writes one line of text, `size` pixels high, its upper left corner at `(x, y)`.
    pub fn text(&mut self, x: usize, y: usize, size: f32, color: [u8; 3], text: &str) {
        let font = FontRef::try_from_slice(UBUNTU_LIGHT).expect("the font that the crate ships");
        let font = font.as_scaled(size);
        let mut pen = ab_glyph::point(x as f32, y as f32 + font.ascent());
        let mut previous = None;
        for character in text.chars() {
            let mut glyph = font.scaled_glyph(character);
            pen.x += previous.map_or(0.0, |p| font.kern(p, glyph.id));
            glyph.position = pen;
            pen.x += font.h_advance(glyph.id);
            previous = Some(glyph.id);
            let Some(outline) = font.outline_glyph(glyph) else {
                continue;
            };
            let corner = outline.px_bounds().min;
            outline.draw(|dx, dy, coverage| {
                self.blend(
                    corner.x as i32 + dx as i32,
                    corner.y as i32 + dy as i32,
                    color,
                    coverage,
                );
            });
        }
    }

    /// Mixes `color` into a pixel; nothing happens outside the picture.
    fn blend(&mut self, x: i32, y: i32, color: [u8; 3], share: f32) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else {
            return;
        };
        if x < self.width && y < self.height {
            let pixel = &mut self.pixels[y * self.width + x];
            for (old, new) in pixel.iter_mut().zip(color) {
                let mixed =
                    f32::from(*old) + share.clamp(0.0, 1.0) * (f32::from(new) - f32::from(*old));
                *old = mixed.round() as u8;
            }
        }
    }

    /// Copies `other` so that its upper left corner comes to `(x, y)`; it has to fit.
    pub fn paste(&mut self, x: usize, y: usize, other: &Picture) {
        for (row, source) in other.pixels.chunks_exact(other.width).enumerate() {
            let start = (y + row) * self.width + x;
            self.pixels[start..start + other.width].copy_from_slice(source);
        }
    }

    /// The picture at `1 / factor` of its size, each pixel the mean of a square.
    pub fn reduced(&self, factor: usize) -> Picture {
        let (width, height) = (self.width / factor, self.height / factor);
        let mean = |x: usize, y: usize, channel: usize| {
            let rows = y * factor..(y + 1) * factor;
            let sum: usize = rows
                .flat_map(|row| &self.pixels[row * self.width + x * factor..][..factor])
                .map(|pixel| usize::from(pixel[channel]))
                .sum();
            (sum / (factor * factor)) as u8
        };
        let pixels = (0..width * height)
            .map(|i| [0, 1, 2].map(|channel| mean(i % width, i / width, channel)))
            .collect();
        Picture {
            width,
            height,
            pixels,
        }
    }
}

/// Pictures of one size side by side in `columns`, each reduced by `factor`, its label above it.
pub fn contact_sheet(pictures: &[(String, Picture)], columns: usize, factor: usize) -> Picture {
    const GAP: usize = 8;
    const CAPTION: usize = 34;
    let Some((_, first)) = pictures.first() else {
        return Picture::new(1, 1, [255; 3]);
    };
    let columns = columns.clamp(1, pictures.len());
    let rows = pictures.len().div_ceil(columns);
    let (tile_width, tile_height) = (first.width / factor + GAP, first.height / factor + CAPTION);
    let (width, height) = (columns * tile_width + GAP, rows * tile_height + GAP);
    let mut sheet = Picture::new(width, height, [255; 3]);
    for (i, (label, picture)) in pictures.iter().enumerate() {
        let (x, y) = (i % columns * tile_width + GAP, i / columns * tile_height);
        sheet.text(x + 2, y + 5, 26.0, [25, 30, 40], label);
        sheet.paste(x, y + CAPTION, &picture.reduced(factor));
    }
    sheet
}
