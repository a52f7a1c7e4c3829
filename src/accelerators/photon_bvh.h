// SPDX-License-Identifier: Apache-2.0
// Beams through photons: the photons of a PhotonKdTree with a radius each, or one for all, as a
// bounding volume hierarchy of 8 children per node. A query finds the photons whose disc,
// perpendicular to a stretch of a ray, that ray crosses (isInBeam), each exactly once.
#pragma once

#include <optional>

#include "accelerators/beam_photon.h"
#include "accelerators/photon_kdtree.h"

namespace brume {

/// What the kernels see.
struct PhotonBvhView {
  using LaneRow = std::array<float, kLanes>;
  PhotonTreeView tree;
  /// Of each photon, of each block (the radii of level 1), or radius2 for all.
  enum class Radii { Each, OfBlocks, Same };
  Radii kind = Radii::Same;
  const LaneRow* radii2 = nullptr;  ///< Each: by block
  /// The largest radius in each child, by level like the nodes; not with Same.
  std::array<const LaneRow*, PhotonTreeView::kMaxLevels> childRadii{};
  float radius2 = 0;
};

/// A stretch of a ray. |d| = 1.
struct BeamQuery {
  Vec3 o{0}, d{0, 0, 1};
  Interval range;
};

/// The tree must outlive it. Squares of coordinates must not overflow.
class PhotonBvh {
 public:
  /// One radius >= 0 for all photons.
  PhotonBvh(const PhotonKdTree& tree, float radius);
  /// A squared radius for each photon, in the order of the tree. Memory per photon: 4.6 bytes, or
  /// 0.6 where the photons of each block have equal radii (adaptiveRadii2).
  PhotonBvh(const PhotonKdTree& tree, std::span<const float> radii2);

  float radius2(std::size_t i) const {
    const std::size_t block = i / kLanes;
    switch (view_.kind) {
      case PhotonBvhView::Radii::Each:
        return view_.radii2[block][i % kLanes];
      case PhotonBvhView::Radii::OfBlocks:
        return sqr(view_.childRadii[1][block / kLanes][block % kLanes]);
      case PhotonBvhView::Radii::Same:
        break;
    }
    return view_.radius2;
  }
  /// Of the radii alone.
  std::size_t memoryBytes() const {
    return (radii2_.size() + childRadii_.size()) * sizeof(LaneRow);
  }

  /// Calls f(index, foot) for each photon of the beam, each once, in an order that depends on tree
  /// and query alone.
  template <class F>
  void forEachInBeam(const BeamQuery& beam, F&& f) const {
    forEachBatchInBeam(beam, [&](const Found& batch, std::size_t n) {
      for (std::size_t i = 0; i < n; ++i)
        f(batch.indices[i], BeamFoot<float>{batch.t[i], batch.distances2[i]});
    });
  }

  /// Photons of a beam, and their squared radii.
  struct Found : PhotonKdTree::Found {
    std::array<float, PhotonKdTree::kBatch + kLanes> t, radii2;
  };
  /// The same, many photons at a time: f(found, count); there is room for whole rows of lanes.
  template <class F>
  void forEachBatchInBeam(const BeamQuery& beam, F&& f) const {
    PhotonKdTree::Search search(view_.tree);
    Found batch;
    while (const std::size_t n = searchBeam(search, beam, batch)) f(batch, n);
  }

 private:
  using LaneRow = PhotonBvhView::LaneRow;
  std::size_t searchBeam(PhotonKdTree::Search& search, const BeamQuery& beam, Found& found) const;

  std::vector<LaneRow> radii2_, childRadii_;
  PhotonBvhView view_;
};

/// Squared radii that follow the density: about k photons lie within each photon's radius. Pilot
/// radii are those of the balls with k photons around the middle of each block of 8 neighbours, so
/// they vary slowly; with fewer than k photons at all they grow by the law of space, r^3 ~ k. None
/// is 0, even where photons coincide. Source: Jarosz, Zwicker, Jensen 2008, 5.1.
std::vector<float> adaptiveRadii2(const PhotonKdTree& tree, std::size_t k);

}  // namespace brume
