//! What an entity is and says follows from its components, whatever was done to it before.

use crate::random_world::{Deed, RandomWorld};
use crate::twins::{check, compare, is_quiet, twin};

fn no_history(deeds: &[Deed]) -> Result<(), String> {
    let mut scene = RandomWorld::new(true);
    deeds.iter().for_each(|&deed| scene.run(deed));
    // What breaks in the last step is read in the next.
    scene.run(Deed::Frame(1));
    if !(0..20).any(|_| is_quiet(&mut scene)) {
        return Ok(());
    }
    let (mut other, twins) = twin(&scene);
    other.update();
    compare(scene.app.world(), other.world(), &twins)
        .map_err(|error| format!("{error}\n{:#?}", scene.said))
}

#[test]
fn entities_are_what_their_components_say_whatever_was_done_before() {
    check(no_history, 40, 0..300);
    check(no_history, 120, 3100..3180);
}
