//! Where the nodes of a glTF document are, and where skins have their vertices while nothing is animated.

use crate::import::error::ModelFileError;
use crate::import::gltf_data::File;
use crate::import::model::ModelObject;
use glam::{Mat3, Mat4, Vec3, Vec4};
use gltf::mesh::Semantic;
use gltf::{Node, Primitive};

/// The nodes of the scene in order, and the frames of all nodes.
pub(super) struct Skeleton<'a> {
    in_scene: Vec<(Node<'a>, Mat4)>,
    /// By node: its frame in that of the scene.
    frames: Vec<Mat4>,
}

impl<'a> Skeleton<'a> {
    /// The default scene, or the first one, or all nodes of a document without scenes.
    pub(super) fn of(file: &'a File) -> Result<Self, ModelFileError> {
        let document = &file.document;
        let mut skeleton = Self {
            in_scene: Vec::new(),
            frames: vec![Mat4::IDENTITY; document.nodes().count()],
        };
        let scene = document
            .default_scene()
            .or_else(|| document.scenes().next());
        let roots: Vec<Node<'a>> = match scene {
            Some(scene) => scene.nodes().collect(),
            None => {
                let children: Vec<usize> = document
                    .nodes()
                    .flat_map(|n| n.children().map(|c| c.index()).collect::<Vec<_>>())
                    .collect();
                document
                    .nodes()
                    .filter(|node| !children.contains(&node.index()))
                    .collect()
            }
        };
        let mut left: Vec<(Node<'a>, Mat4)> = roots
            .into_iter()
            .rev()
            .map(|node| (node, Mat4::IDENTITY))
            .collect();
        while let Some((node, scene_from_parent)) = left.pop() {
            if skeleton.in_scene.len() > skeleton.frames.len() {
                let reason = "its nodes are their own children".to_string();
                return Err(ModelFileError::Damaged { reason });
            }
            let frame = scene_from_parent * Mat4::from_cols_array_2d(&node.transform().matrix());
            skeleton.frames[node.index()] = frame;
            let children: Vec<Node<'a>> = node.children().collect();
            left.extend(children.into_iter().rev().map(|child| (child, frame)));
            skeleton.in_scene.push((node, frame));
        }
        Ok(skeleton)
    }

    /// The nodes of the scene and their frames.
    pub(super) fn nodes(&self) -> impl Iterator<Item = &(Node<'a>, Mat4)> {
        self.in_scene.iter()
    }

    /// Moves the vertices of a primitive into the frame of the scene; whether that mirrors them.
    ///
    /// Where a skin moves a vertex, its node does not: with weights `w_i`, frames of joints `J_i` and inverse bind matrices
    /// `B_i` it is at `sum w_i J_i B_i p`.
    pub(super) fn place(
        &self,
        file: &File,
        node: &Node<'_>,
        primitive: &Primitive<'_>,
        scene_from_node: Mat4,
        part: &mut ModelObject,
    ) -> Result<bool, ModelFileError> {
        let joints = primitive.get(&Semantic::Joints(0));
        let weights = primitive.get(&Semantic::Weights(0));
        let (Some(skin), Some(joints), Some(weights)) = (node.skin(), joints, weights) else {
            return Ok(part.transform(scene_from_node));
        };
        let bind: Vec<[f32; 16]> = file.read_all(skin.inverse_bind_matrices())?;
        let matrices: Vec<Mat4> = (skin.joints().enumerate())
            .map(|(place, joint)| {
                let bind = bind
                    .get(place)
                    .map_or(Mat4::IDENTITY, Mat4::from_cols_array);
                self.frames[joint.index()] * bind
            })
            .collect();
        let joints: Vec<[f32; 4]> = file.read(&joints)?;
        let weights: Vec<[f32; 4]> = file.read(&weights)?;
        let mut mirrored = false;
        let vertices = joints.iter().zip(&weights).take(part.positions.len());
        for (vertex, (joints, weights)) in vertices.enumerate() {
            let total = Vec4::from(*weights).element_sum();
            let weighted = joints.iter().zip(weights).map(|(&joint, &weight)| {
                matrices
                    .get(joint as usize)
                    .copied()
                    .unwrap_or(scene_from_node)
                    * (weight / total)
            });
            let matrix = if total > 0.0 {
                weighted.fold(Mat4::ZERO, |sum, m| sum + m)
            } else {
                scene_from_node
            };
            part.positions[vertex] = matrix.transform_point3(part.positions[vertex]);
            if let Some(normal) = part.normals.get_mut(vertex) {
                *normal = matrix
                    .transform_vector3(*normal)
                    .try_normalize()
                    .unwrap_or(Vec3::Y);
            }
            mirrored = matrix.determinant() < 0.0;
        }
        Ok(mirrored)
    }
}

impl ModelObject {
    /// Moves an object by a matrix; whether that mirrors it.
    fn transform(&mut self, matrix: Mat4) -> bool {
        let normal_matrix = Mat3::from_mat4(matrix).inverse().transpose();
        for position in &mut self.positions {
            *position = matrix.transform_point3(*position);
        }
        for normal in &mut self.normals {
            *normal = (normal_matrix * *normal).try_normalize().unwrap_or(Vec3::Y);
        }
        matrix.determinant() < 0.0
    }
}
