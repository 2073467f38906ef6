//! A short film as GIF: a pane shatters in slow motion, a figurine is sliced, a wall falls, and another one under a ball on a chain.

use super::Offscreen;
use crate::exhibits::Exhibit;
use crate::panel::Action;
use bevy::prelude::*;
use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::Duration;

const SIZE: UVec2 = UVec2::new(640, 360);
/// Frames a second of the film; hundredths of a second are what a GIF counts in.
const RATE: u16 = 20;
const FRAME: Duration = Duration::from_millis(50);

/// What happens in the film, frame by frame.
enum Cue {
    Show(Exhibit),
    Slow,
    Throw([f32; 2]),
    Swipe([f32; 4]),
    /// Lets so many frames of the film pass.
    Run(u32),
}

const SCRIPT: [Cue; 25] = [
    Cue::Show(Exhibit::Glass),
    Cue::Run(4),
    Cue::Throw([0.56, 0.42]),
    Cue::Run(2),
    Cue::Slow,
    Cue::Run(22),
    Cue::Slow,
    Cue::Run(14),
    Cue::Show(Exhibit::Figurine),
    Cue::Run(2),
    Cue::Slow,
    Cue::Swipe([0.30, 0.12, 0.70, 0.46]),
    Cue::Run(20),
    Cue::Slow,
    Cue::Run(18),
    Cue::Show(Exhibit::Brick),
    Cue::Run(4),
    Cue::Throw([0.44, 0.40]),
    Cue::Run(2),
    Cue::Throw([0.56, 0.44]),
    Cue::Run(2),
    Cue::Throw([0.50, 0.32]),
    Cue::Run(26),
    Cue::Show(Exhibit::Wrecking),
    Cue::Run(44),
];

/// Films the script into `file`.
pub(crate) fn take(file: &Path) -> Result<(), Box<dyn Error>> {
    let mut studio = Offscreen::new(SIZE, FRAME);
    let mut count = 0;
    for cue in SCRIPT {
        match cue {
            Cue::Show(exhibit) => {
                studio.press(Action::Show(exhibit));
                // It is there with the next frame.
                studio.frames(2);
            }
            Cue::Slow => studio.press(Action::Slow),
            Cue::Throw(at) => studio.throw(at.into()),
            Cue::Swipe([x, y, to_x, to_y]) => studio.swipe(Vec2::new(x, y), Vec2::new(to_x, to_y)),
            Cue::Run(frames) => {
                for _ in 0..frames {
                    studio.shoot();
                    studio.frames(1);
                    count += 1;
                }
            }
        }
    }
    let mut frames = Vec::new();
    for picture in studio.pictures(count)? {
        frames.push(picture.try_into_dynamic()?.to_rgba8().into_raw());
    }
    write(file, &frames)
}

/// One palette for all frames, so that what rests does not flicker; what does not change from frame to frame is left out.
fn write(file: &Path, frames: &[Vec<u8>]) -> Result<(), Box<dyn Error>> {
    const TRANSPARENT: u8 = 255;
    let sample: Vec<u8> = frames.iter().step_by(6).flatten().copied().collect();
    let quantizer = color_quant::NeuQuant::new(10, TRANSPARENT.into(), &sample);
    let palette: Vec<u8> = quantizer.color_map_rgb();
    let [width, height] = [SIZE.x as u16, SIZE.y as u16];
    let mut encoder =
        gif::Encoder::new(BufWriter::new(File::create(file)?), width, height, &palette)?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    let mut before: Vec<u8> = Vec::new();
    for rgba in frames {
        let indexed: Vec<u8> = rgba
            .chunks_exact(4)
            .map(|pixel| quantizer.index_of(pixel) as u8)
            .collect();
        let is_same = |i: usize| before.get(i) == Some(&indexed[i]);
        let changed = (0..indexed.len()).map(|i| if is_same(i) { TRANSPARENT } else { indexed[i] });
        let frame = gif::Frame {
            delay: 100 / RATE,
            width,
            height,
            transparent: Some(TRANSPARENT),
            dispose: gif::DisposalMethod::Keep,
            buffer: changed.collect::<Vec<u8>>().into(),
            ..Default::default()
        };
        encoder.write_frame(&frame)?;
        before = indexed;
    }
    Ok(())
}
