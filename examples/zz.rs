use bevy_cleave::prelude::*;
use bevy_math::Vec3;
fn main() {
    
    let mut simulation = Simulation::default();
    let floor = BodyDesc::floor(HalfSpace { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("a floor needs no mass");
    let pane = ConvexMesh::cuboid(1.0, 0.05, 1.0).expect("a pane has a volume");
    let glass = FracturePattern::Radial { rays: 12, rings: 4 };
    let pane = BodyDesc {
        fracturable: Some(Fracturable::with_strength(40.0).with_pattern(glass)), // N s
        ..BodyDesc::dynamic(pane, Vec3::new(0.0, 8.0, 0.0))
    };
    simulation.bodies.insert(pane).expect("a pane has a mass");
    (0..120).for_each(|_| simulation.step(1.0 / 60.0));
    assert!(simulation.bodies.len() > 10); // it broke when it hit the floor
    println!("{} {:?}", simulation.bodies.len(), simulation.bodies.iter().map(|s| simulation.bodies.center_of_mass(s)).collect::<Vec<_>>());
}
