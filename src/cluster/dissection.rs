//! An order of the parts of a cluster in which their system is factorised with little work.

use crate::cluster::network::Network;
use glam::DVec3;

/// Parts that are not divided any more.
const FEW: usize = 8;

/// The group of a part that is in none.
const NOWHERE: u32 = u32::MAX;

impl Network {
    /// Parts in an order of nested dissection by their centers: each group is divided where it is longest, and the parts of one half that have
    /// bonds to the other half come last.
    pub(super) fn dissected(&self, parts: Vec<u32>, is_broken: &[bool]) -> Vec<u32> {
        let mut group = vec![NOWHERE; self.nodes.len()];
        parts.iter().for_each(|&part| group[part as usize] = 0);
        // From the last part to the first one.
        let mut order = Vec::with_capacity(parts.len());
        let mut number = 0;
        let mut waiting = vec![parts];
        while let Some(mut parts) = waiting.pop() {
            if parts.len() <= FEW {
                order.extend(parts);
                continue;
            }
            let half = self.halve(&mut parts);
            number += 2;
            for (at, &part) in parts.iter().enumerate() {
                group[part as usize] = number - u32::from(at < half);
            }
            let is_between = |&part: &u32| {
                let mut bonds = self.bonds_of(part).iter();
                bonds.any(|&bond| {
                    let other = self.other(bond, part);
                    !is_broken[bond as usize] && group[other as usize] == number
                })
            };
            let second = parts.split_off(half);
            let (between, first): (Vec<u32>, Vec<u32>) = parts.into_iter().partition(is_between);
            order.extend(between);
            waiting.extend([first, second]);
        }
        order.reverse();
        order
    }

    /// Sorts parts by their centers along the direction in which these reach farthest; how many are in the first half.
    fn halve(&self, parts: &mut [u32]) -> usize {
        let center = |part: u32| self.nodes[part as usize].center;
        let all = parts.iter().map(|&part| center(part));
        let (low, high) = all.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        let axis = (high - low).max_position();
        parts.sort_unstable_by(|&a, &b| {
            let order = center(a)[axis].total_cmp(&center(b)[axis]);
            order.then(a.cmp(&b))
        });
        parts.len() / 2
    }
}
