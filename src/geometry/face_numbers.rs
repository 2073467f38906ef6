//! Which triangles of a mesh are one flat face, as far as that is known.

/// By triangle the number of its face; empty where nothing is known. Triangles of one number hang together, lie in one plane
/// and have attributes that are one affine function of the position, so that they can be divided otherwise. No part of the mesh's value:
/// all are equal.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaceNumbers(pub(crate) Vec<u32>);

impl FaceNumbers {
    /// Forgets the faces.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// A number that no face of a mesh with so many triangles has.
    pub(crate) fn first_free(&self, triangles: usize) -> u32 {
        let largest = self.0.iter().max();
        largest.map_or(triangles as u32, |&face| face + 1)
    }

    /// The number of the face of a triangle, which is one of its own where nothing is known.
    pub(crate) fn of(&self, triangle: u32) -> u32 {
        self.0.get(triangle as usize).copied().unwrap_or(triangle)
    }
}

impl PartialEq for FaceNumbers {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
