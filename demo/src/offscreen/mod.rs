//! The playground without a window: time by hand, and pictures of what the camera sees.

pub(crate) mod film;
pub(crate) mod pictures;

use crate::ball::Throw;
use crate::panel::Action;
use crate::playground::PlaygroundPlugin;
use crate::swipe::Swipe;
use bevy::app::PluginsState;
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::time::TimeUpdateStrategy;
use bevy::window::ExitCondition;
use bevy::winit::WinitPlugin;
use std::error::Error;
use std::time::Duration;

/// Frames until the renderer has all it needs: with 2 the picture is blank.
const WARM_UP: u32 = 4;
/// Most frames that a picture takes to come back from the renderer.
const PATIENCE: u32 = 60;

/// A studio that nobody watches.
pub(crate) struct Offscreen {
    app: App,
    target: Handle<Image>,
}

/// The pictures that came back from the renderer, in order.
#[derive(Default, Resource)]
struct Taken(Vec<Image>);

impl Offscreen {
    /// A studio with a picture of `size` pixels; each frame takes `frame` of time.
    pub(crate) fn new(size: UVec2, frame: Duration) -> Self {
        let mut app = App::new();
        let plugins = bevy::DefaultPlugins
            .set(WindowPlugin {
                primary_window: None,
                exit_condition: ExitCondition::DontExit,
                ..default()
            })
            // Else the first frames miss whatever is not compiled yet.
            .set(RenderPlugin {
                synchronous_pipeline_compilation: true,
                ..default()
            })
            .disable::<WinitPlugin>();
        app.add_plugins((plugins, PlaygroundPlugin))
            .init_resource::<Taken>()
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
        while app.plugins_state() == PluginsState::Adding {
            std::thread::sleep(Duration::from_millis(2));
        }
        app.finish();
        app.cleanup();
        let mut image =
            Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        let mut studio = Self { app, target };
        // The camera comes with the first frame.
        studio.app.update();
        let world = studio.app.world_mut();
        let camera = world
            .query_filtered::<Entity, With<Camera3d>>()
            .single(world);
        let target = RenderTarget::Image(studio.target.clone().into());
        world
            .entity_mut(camera.expect("one camera"))
            .insert((target, Msaa::Sample4));
        studio.warm_up();
        studio
            .app
            .insert_resource(TimeUpdateStrategy::ManualDuration(frame));
        studio
    }

    /// Lets time pass. What nobody asked a picture of is not drawn.
    pub(crate) fn frames(&mut self, count: u32) {
        (0..count).for_each(|_| self.app.update());
        self.draw(false);
    }

    fn draw(&mut self, is_drawn: bool) {
        let world = self.app.world_mut();
        for mut camera in world.query::<&mut Camera>().iter_mut(world) {
            camera.is_active = is_drawn;
        }
    }

    /// Shows figures and buttons, or not.
    pub(crate) fn panel(&mut self, is_shown: bool) {
        let world = self.app.world_mut();
        let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
        if let Ok(camera) = cameras.single(world) {
            let mut camera = world.entity_mut(camera);
            if is_shown {
                camera.insert(IsDefaultUiCamera);
            } else {
                camera.remove::<IsDefaultUiCamera>();
            }
        }
    }

    pub(crate) fn press(&mut self, action: Action) {
        self.app.world_mut().write_message(action);
    }

    /// A swipe between two places of the picture, in shares of its width and height.
    pub(crate) fn swipe(&mut self, from: Vec2, to: Vec2) {
        let size = self.size();
        self.app.world_mut().write_message(Swipe {
            from: from * size,
            to: to * size,
        });
    }

    /// A ball at a place of the picture, in shares of its width and height.
    pub(crate) fn throw(&mut self, at: Vec2) {
        let at = at * self.size();
        let world = self.app.world_mut();
        let mut cameras = world.query::<(&Camera, &GlobalTransform)>();
        let ray = cameras
            .single(world)
            .ok()
            .and_then(|(camera, eye)| camera.viewport_to_world(eye, at).ok());
        if let Some(ray) = ray {
            world.write_message(Throw(ray));
        }
    }

    fn size(&self) -> Vec2 {
        let images = self.app.world().resource::<Assets<Image>>();
        images.get(&self.target).map_or(Vec2::ONE, Image::size_f32)
    }

    /// Asks for a picture of the next frame.
    pub(crate) fn shoot(&mut self) {
        self.draw(true);
        let world = self.app.world_mut();
        world.spawn(Screenshot::image(self.target.clone())).observe(
            |captured: On<ScreenshotCaptured>, mut taken: ResMut<Taken>| {
                taken.0.push(captured.image.clone());
            },
        );
    }

    /// Draws until the renderer has all it needs. No time passes.
    pub(crate) fn warm_up(&mut self) {
        let running = self.stop();
        (0..WARM_UP).for_each(|_| self.app.update());
        self.app.insert_resource(running);
    }

    /// Draws until all of the `count` pictures that were asked for are there. No time passes.
    pub(crate) fn pictures(&mut self, count: usize) -> Result<Vec<Image>, Box<dyn Error>> {
        let running = self.stop();
        let taken = |app: &App| app.world().resource::<Taken>().0.len();
        for _ in 0..PATIENCE {
            if taken(&self.app) >= count {
                break;
            }
            self.app.update();
        }
        self.app.insert_resource(running);
        if taken(&self.app) < count {
            return Err("a picture did not come back from the renderer".into());
        }
        Ok(std::mem::take(
            &mut self.app.world_mut().resource_mut::<Taken>().0,
        ))
    }

    /// Stops the clock while all is drawn; how it went.
    fn stop(&mut self) -> TimeUpdateStrategy {
        self.draw(true);
        let world = self.app.world_mut();
        let stopped = TimeUpdateStrategy::ManualDuration(Duration::ZERO);
        std::mem::replace(&mut *world.resource_mut::<TimeUpdateStrategy>(), stopped)
    }
}
