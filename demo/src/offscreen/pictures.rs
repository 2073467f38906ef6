//! Pictures of every exhibit, as PNG files.

use super::Offscreen;
use crate::exhibits::Exhibit;
use crate::panel::Action;
use bevy::prelude::*;
use std::error::Error;
use std::path::Path;
use std::time::Duration;

const SIZE: UVec2 = UVec2::new(1280, 720);
const FRAME: Duration = Duration::from_nanos(16_666_667);

/// What is done to an exhibit, and when it is looked at.
struct Shot {
    name: &'static str,
    exhibit: Exhibit,
    /// Frames before anything is done.
    wait: u32,
    /// Places at which balls are thrown, in shares of the picture.
    throws: &'static [[f32; 2]],
    /// Frames between one throw and the next.
    pause: u32,
    /// Ends of swipes.
    swipes: &'static [[f32; 4]],
    /// Frames after that.
    after: u32,
    /// Whether figures and buttons are in the picture.
    panel: bool,
    debug: bool,
}

const PLAIN: Shot = Shot {
    name: "",
    exhibit: Exhibit::All,
    wait: 2,
    throws: &[],
    pause: 6,
    swipes: &[],
    after: 0,
    panel: false,
    debug: false,
};

const SHOTS: [Shot; 13] = [
    Shot {
        name: "playground",
        throws: &[[0.70, 0.42], [0.30, 0.36], [0.38, 0.45]],
        wait: 16,
        after: 20,
        panel: true,
        ..PLAIN
    },
    Shot {
        name: "glass",
        exhibit: Exhibit::Glass,
        throws: &[[0.56, 0.42]],
        after: 24,
        ..PLAIN
    },
    Shot {
        name: "brick",
        exhibit: Exhibit::Brick,
        throws: &[[0.44, 0.40], [0.56, 0.44], [0.50, 0.32]],
        after: 30,
        ..PLAIN
    },
    Shot {
        name: "wood",
        exhibit: Exhibit::Wood,
        throws: &[[0.48, 0.385]],
        after: 20,
        ..PLAIN
    },
    Shot {
        name: "stone",
        exhibit: Exhibit::Stone,
        after: 68,
        ..PLAIN
    },
    Shot {
        name: "concrete",
        exhibit: Exhibit::Concrete,
        throws: &[[0.45, 0.40], [0.57, 0.47], [0.50, 0.30]],
        after: 30,
        ..PLAIN
    },
    Shot {
        name: "figurine",
        exhibit: Exhibit::Figurine,
        wait: 24,
        after: 6,
        ..PLAIN
    },
    Shot {
        name: "table",
        exhibit: Exhibit::Furniture,
        wait: 30,
        throws: &[[0.47, 0.42]],
        after: 26,
        panel: true,
        ..PLAIN
    },
    Shot {
        name: "chain",
        exhibit: Exhibit::Wrecking,
        after: 62,
        ..PLAIN
    },
    Shot {
        name: "tower",
        exhibit: Exhibit::Tower,
        throws: &[[0.47, 0.42], [0.55, 0.50], [0.52, 0.34]],
        after: 26,
        panel: true,
        ..PLAIN
    },
    Shot {
        name: "slice",
        exhibit: Exhibit::Figurine,
        wait: 2,
        swipes: &[[0.30, 0.12, 0.70, 0.46]],
        after: 15,
        ..PLAIN
    },
    Shot {
        name: "sliced_pane",
        exhibit: Exhibit::Glass,
        wait: 2,
        swipes: &[[0.35, 0.61, 0.65, 0.35]],
        after: 24,
        ..PLAIN
    },
    Shot {
        name: "debug",
        exhibit: Exhibit::Brick,
        throws: &[[0.44, 0.40]],
        after: 24,
        panel: true,
        debug: true,
        ..PLAIN
    },
];

/// Takes pictures into `folder`, those with these names or all.
pub(crate) fn take(folder: &Path, names: &[&str]) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    let mut studio = Offscreen::new(SIZE, FRAME);
    let is_wanted = |shot: &&Shot| names.is_empty() || names.contains(&shot.name);
    for shot in SHOTS.iter().filter(is_wanted) {
        studio.press(Action::Show(shot.exhibit));
        studio.frames(1 + shot.wait);
        for &at in shot.throws {
            studio.throw(at.into());
            studio.frames(shot.pause);
        }
        for &[x, y, to_x, to_y] in shot.swipes {
            studio.swipe(Vec2::new(x, y), Vec2::new(to_x, to_y));
        }
        studio.frames(shot.after);
        if shot.debug {
            studio.press(Action::Debug);
            studio.frames(1);
        }
        studio.panel(shot.panel);
        studio.warm_up();
        studio.shoot();
        for picture in studio.pictures(1)? {
            let rgb = picture.try_into_dynamic()?.to_rgb8();
            let file = folder.join(shot.name).with_extension("png");
            save(&file, rgb.dimensions(), &rgb)?;
        }
    }
    Ok(())
}

fn save(path: &Path, (width, height): (u32, u32), rgb: &[u8]) -> Result<(), Box<dyn Error>> {
    let file = std::io::BufWriter::new(std::fs::File::create(path)?);
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(rgb)?;
    Ok(())
}
