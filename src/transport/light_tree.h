// SPDX-License-Identifier: Apache-2.0
// Choice of one light among many, by what they can send to a point or to a stretch of a ray.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/scene.h"

namespace brume {

/// The lights of the scene that emit anything at all (a black light costs shadow rays and gives
/// nothing).
std::vector<const Light*> emittingLights(const Scene& scene);

/// LightBounds as balls, with what a traversal needs of the angles: eight side by side, so that a
/// receiver sees all of them in one loop. In the space of the tree: its centre 0, its radius 1, its
/// strongest light 1. Unused places have no intensity.
struct LightClusters {
  static constexpr std::size_t kWidth = 8;
  using Floats = std::array<float, kWidth>;
  alignas(32) Floats x{}, y{}, z{}, radius{}, intensity{};
  /// Half-angle of the axes' cone, and how far from it light goes.
  alignas(32) Floats axisX{}, axisY{}, axisZ{}, cosAxes{}, sinAxes{}, cosEmission{};
  bool isUniform = true;  ///< all of them shine everywhere

  void set(std::size_t lane, const LightBounds& bounds, const Vec3d& center, double scale,
           double strongest);
};

/// What a receiver sees of eight clusters.
struct ClusterViews {
  alignas(32) LightClusters::Floats importance;
  /// Bit per place. Not set: some of the receiver lies in the ball, so that the estimate is poor.
  std::uint32_t isOutside = 0;
};

/// The space of a tree: p' = (p - center) * scale.
struct LightTreeSpace {
  Vec3d center{0};
  double scale = 1;
  double strongest = 1;  ///< intensity that is 1 there
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

  /// The same in the space of a tree.
  struct Local {
    Vec3 p{0}, n{0};
    bool hasNormal = false;
    double unit = 1;  ///< irradiance that is 1 here
    void see(const LightClusters& clusters, ClusterViews& views) const;
  };
  Local in(const LightTreeSpace& space) const;
  /// Of lights without bounds, whose irradiance is the same everywhere.
  double importance(double irradiance) const { return irradiance; }

 private:
  Vec3 p_, n_{0};
  bool hasNormal_ = false;
};

/// A stretch of a ray that wants light: the same summed along it, about I Int 1 / (D^2 + t^2) dt
/// with D^2 = d^2 + r^2 / 10, d the distance from the centre to the line; 0 where no direction of
/// emission can meet it.
class RayReceiver {
 public:
  RayReceiver(const Ray& ray, Interval range) : ray_(ray), range_(range) {}

  struct Local {
    Vec3 o{0}, d{0};  ///< o is the line's point nearest to the centre
    float t0 = 0, t1 = 0;
    double unit = 1;
    void see(const LightClusters& clusters, ClusterViews& views) const;
  };
  Local in(const LightTreeSpace& space) const;
  double importance(double irradiance) const { return irradiance * double{range_.length()}; }

 private:
  Ray ray_;
  Interval range_;
};

/// Tree over the lights that have bounds, eight children to a node: a binary one, split by the
/// surface area orientation heuristic, of which each node takes in the widest nodes below it. Nodes
/// that surround the receiver are opened, up to a fixed number; one of the clusters that remain is
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
  /// Nodes opened for one receiver, PointReceiver or RayReceiver, with the importance of what is
  /// not opened below: holds every light once. To ask several questions for one receiver.
  template <class Receiver>
  class Cut;
  template <class Receiver>
  Cut<Receiver> cut(const Receiver& receiver) const;
  /// None without lights, and where no light can arrive.
  template <class Receiver>
  std::optional<Choice> choose(const Cut<Receiver>& cut, float u) const;
  /// Of choosing this light; 0 for one that is not in the tree.
  template <class Receiver>
  float probability(const Cut<Receiver>& cut, const Light* light) const;

  template <class Receiver>
  std::optional<Choice> choose(const Receiver& receiver, float u) const {
    return choose(cut(receiver), u);
  }
  template <class Receiver>
  float probability(const Receiver& receiver, const Light* light) const {
    return probability(cut(receiver), light);
  }

  bool isEmpty() const { return lights_.empty(); }
  const std::vector<const Light*>& lights() const { return lights_; }
  /// Whether any light can be hit by a ray, so that sampling directions finds light.
  bool hasHittableLights() const { return hasHittable_; }

 private:
  static constexpr std::size_t kWidth = LightClusters::kWidth;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  /// Nodes of a cut.
  static constexpr std::size_t kMostOpen = 8;

  struct Node {
    LightClusters clusters;
    std::array<std::uint32_t, kWidth> child{};  ///< a node, or a light where isLight says so
    std::uint32_t isLight = 0;                  ///< bit per place
    std::uint32_t count = 0;
    std::uint32_t parent = kNone, place = 0;  ///< the node above and where it holds this one
  };
  class Builder;

  struct Drawn {
    std::uint32_t light = kNone;
    double probability = 0;
  };
  template <class Local>
  Drawn descend(const Local& receiver, std::uint32_t node, double x, double p) const;
  template <class Receiver>
  Drawn draw(const Cut<Receiver>& cut, double x) const;
  template <class Receiver>
  double probabilityByImportance(const Cut<Receiver>& cut, std::uint32_t light) const;
  std::size_t firstSlot(const Light* light) const;
  std::optional<std::uint32_t> indexOf(const Light* light) const;

  std::vector<const Light*> lights_;
  std::vector<std::uint32_t> slots_;   // by hash of the address, kNone where free: see indexOf
  std::vector<double> irradiance_;     // of lights without bounds, else 0
  std::vector<std::uint32_t> leafOf_;  // 8 times the node of each light plus its place, or kNone
  std::vector<std::uint32_t> unbounded_;
  std::vector<Node> nodes_;
  LightTreeSpace space_;
  double unboundedIrradiance_ = 0;
  double evenShare_ = 0;
  bool hasHittable_ = false;
};

template <class Receiver>
class LightTree::Cut {
 private:
  friend class LightTree;
  typename Receiver::Local receiver_;
  std::size_t count_ = 0;
  std::array<std::uint32_t, kMostOpen> nodes_;
  std::array<LightClusters::Floats, kMostOpen> importance_;  // 0 where a child is opened itself
  std::array<double, kMostOpen> sums_;
  double unit_ = 1;       // of these importances
  double unbounded_ = 0;  // importance of lights without bounds
  double total_ = 0;
  double perIrradiance_ = 1;  // importance of an irradiance that is the same everywhere

 public:
  /// Knows nothing yet.
  Cut() = default;
};

}  // namespace brume
