//! Cuboid, regular prism, icosphere, wedge.
