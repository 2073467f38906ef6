//! The adapters.

#[cfg(feature = "avian")]
pub(crate) mod avian;
pub(crate) mod bare_app;
#[cfg(feature = "box3d")]
pub(crate) mod box3d;
pub(crate) mod cleave;
pub(crate) mod cleave_plugin;
pub(crate) mod cleave_settings;
pub(crate) mod headless;
#[cfg(feature = "jolt")]
pub(crate) mod jolt;
#[cfg(feature = "rapier")]
pub(crate) mod rapier;
