// SPDX-License-Identifier: Apache-2.0
// Choice of one light among many, by what they can send to a point or to a stretch of a ray.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/scene.h"

namespace brume {

/// The lights of the scene that emit anything at all (a black light costs shadow rays and gives
/// nothing).
std::vector<const Light*> emittingLights(const Scene& scene);

/// LightBounds as a ball, with what a traversal needs of the angles.
struct LightCluster {
  Vec3 center{0};
  float radius = 0;
  Vec3 axis{0, 0, 1};
  float cosAxes = -1, sinAxes = 0;  ///< half-angle of the axes' cone
  float cosEmission = -1;
  double intensity = 0;

  LightCluster() = default;
  explicit LightCluster(const LightBounds& bounds);
};

/// What a receiver sees of a cluster.
struct ClusterView {
  double importance = 0;
  bool isInside = false;  ///< some of the receiver lies in the ball: the estimate is poor
};

/// A point that wants light: about the irradiance that a cluster can send it, visibility ignored,
///   I max(0, cos(angle to the axes)) |cos(angle to n)| / (d^2 + r^2 / 10)
/// with the smallest angles to any point of the ball; 0 where no direction of emission meets p.
class PointReceiver {
 public:
  /// In a medium; render space.
  explicit PointReceiver(const Vec3& p) : p_(p) {}
  /// On a surface of unit normal n; both sides count.
  PointReceiver(const Vec3& p, const Vec3& n) : p_(p), n_(n), hasNormal_(true) {}
  ClusterView see(const LightCluster& cluster) const;
  /// Of a light without bounds, whose irradiance is the same everywhere.
  double importance(double irradiance) const { return irradiance; }

 private:
  Vec3d p_;
  Vec3d n_{0};
  bool hasNormal_ = false;
};

/// A stretch of a ray that wants light: the same summed along it, about I Int 1 / (D^2 + t^2) dt
/// with D^2 = d^2 + r^2 / 10, d the distance from the centre to the line; 0 where no direction of
/// emission can meet it.
class RayReceiver {
 public:
  RayReceiver(const Ray& ray, Interval range);
  ClusterView see(const LightCluster& cluster) const;
  double importance(double irradiance) const { return irradiance * (t1_ - t0_); }

 private:
  Vec3d o_, d_;
  double t0_, t1_;
};

/// Binary tree over the lights that have bounds, split by the surface area orientation heuristic.
/// Nodes that surround the receiver are opened, up to a fixed number; one of those that remain is
/// drawn by importance, and from there on one child after another. Lights without bounds stand
/// beside the tree. A tenth of the probability is shared evenly by all, so that a strong light
/// behind a wall cannot starve the others and none is ever missed. Time O(log n) per choice and per
/// probability, memory and set-up O(n) and O(n log n).
/// Source: Conty Estevez, Kulla 2018, Importance Sampling of Many Lights with Adaptive Tree
/// Splitting. Test: light_tree_test.
class LightTree {
 public:
  struct Options {
    std::optional<LightBounds> media;  ///< the emission of media as one more light, a null Light
    double evenShare = 0.1;            ///< of the probability
  };
  LightTree(std::span<const Light* const> lights, const Options& options);
  explicit LightTree(const Scene& scene) : LightTree(emittingLights(scene), {}) {}

  struct Choice {
    const Light* light = nullptr;  ///< null: the emission of the media
    float probability = 0;
  };
  /// Receiver: PointReceiver or RayReceiver. None without lights, and where no light can arrive.
  template <class Receiver>
  std::optional<Choice> choose(const Receiver& receiver, float u) const;
  /// Of choosing this light; 0 for one that is not in the tree.
  template <class Receiver>
  float probability(const Receiver& receiver, const Light* light) const;

  bool isEmpty() const { return lights_.empty(); }
  const std::vector<const Light*>& lights() const { return lights_; }
  /// Whether any light can be hit by a ray, so that sampling directions finds light.
  bool hasHittableLights() const { return hasHittable_; }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  struct Node {
    LightCluster cluster;
    std::uint32_t parent = kNone;
    std::uint32_t second = kNone;  ///< the first child follows its parent; none: a leaf
    std::uint32_t light = kNone;   ///< of a leaf
  };
  class Builder;

  struct Drawn {
    std::uint32_t light = kNone;
    double probability = 0;
  };
  struct Cut;
  template <class Receiver>
  void makeCut(const Receiver& receiver, Cut& cut) const;
  template <class Receiver>
  Drawn descend(const Receiver& receiver, std::uint32_t node, double x, double p) const;
  template <class Receiver>
  Drawn draw(const Receiver& receiver, double x) const;
  template <class Receiver>
  double probabilityByImportance(const Receiver& receiver, std::uint32_t light) const;
  std::optional<std::uint32_t> indexOf(const Light* light) const;

  std::vector<const Light*> lights_;
  std::vector<std::pair<const Light*, std::uint32_t>> sorted_;  // by address
  std::vector<double> irradiance_;                              // of those without bounds, else 0
  std::vector<std::uint32_t> leafOf_;                           // node of each light, or kNone
  std::vector<std::uint32_t> unbounded_;
  std::vector<Node> nodes_;
  double unboundedIrradiance_ = 0;
  double evenShare_ = 0;
  bool hasHittable_ = false;
};

}  // namespace brume
