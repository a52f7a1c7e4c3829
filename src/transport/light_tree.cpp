// SPDX-License-Identifier: Apache-2.0
#include "transport/light_tree.h"

#include <bit>

#include "core/error.h"
#include "core/lanes_math.h"

namespace brume {
namespace {

/// Angles are widened by this cosine, so that rounding never cuts a light off: the sine of a small
/// angle is off by some 3e-4 when it comes from a float cosine.
constexpr float kSlack = 1e-3f;
/// Radii likewise.
constexpr double kRadiusSlack = 1e-5;
/// Share of r^2 that is added to the squared distance from a cluster's centre.
constexpr float kSpread = 0.1f;
/// Squared distances in the space of the tree are at least, coordinates at most.
constexpr float kNearest2 = 1e-30f;
constexpr double kFarthest = 1e15;
/// Up to this number of lights all nodes are opened.
constexpr std::size_t kFewLights = 16;
/// Light at the border of a cluster's emission still counts this much.
constexpr float kLeastFalloff = 0.05f;

#define BRUME_KERNELS "transport/light_clusters.inl"
#include "core/both_lanes.inl"

}  // namespace

std::vector<const Light*> emittingLights(const Scene& scene) {
  std::vector<const Light*> result;
  for (const auto& light : scene.lights())
    if (!light->power().isBlack()) result.push_back(light.get());
  return result;
}

void LightClusters::set(std::size_t lane, const LightBounds& bounds, const Vec3d& center,
                        double scale, double strongest) {
  const Vec3d c = (Vec3d(bounds.box.center()) - center) * scale;
  x[lane] = static_cast<float>(c.x);
  y[lane] = static_cast<float>(c.y);
  z[lane] = static_cast<float>(c.z);
  const double diameter = length(Vec3d(bounds.box.hi) - Vec3d(bounds.box.lo));
  radius[lane] = static_cast<float>(0.5 * diameter * scale * (1 + kRadiusSlack));
  intensity[lane] = static_cast<float>(bounds.intensity / strongest);
  axisX[lane] = bounds.axes.axis.x;
  axisY[lane] = bounds.axes.axis.y;
  axisZ[lane] = bounds.axes.axis.z;
  cosAxes[lane] = bounds.axes.cosine;
  sinAxes[lane] = safeSqrt(1 - sqr(bounds.axes.cosine));
  cosEmission[lane] = bounds.cosEmission;
  isUniform = isUniform && bounds.axes.isEverything();
}

PointReceiver::Local PointReceiver::in(const LightTreeSpace& space) const {
  const Vec3d p = (Vec3d(p_) - space.center) * space.scale;
  return {Vec3(min(max(p, Vec3d(-kFarthest)), Vec3d(kFarthest))), n_, hasNormal_,
          space.strongest * sqr(space.scale)};
}

void PointReceiver::Local::see(const LightClusters& clusters, ClusterViews& views) const {
  if (hasAvx2())
    avx2::seeFromPoint(*this, clusters, views);
  else
    generic::seeFromPoint(*this, clusters, views);
}

RayReceiver::Local RayReceiver::in(const LightTreeSpace& space) const {
  // From the line's point nearest to the centre no digits are lost to a far origin.
  const Vec3d d(ray_.d), toCenter = space.center - Vec3d(ray_.o);
  const double foot = dot(toCenter, d);
  const auto local = [&](float t) {
    return static_cast<float>(std::clamp((double{t} - foot) * space.scale, -kFarthest, kFarthest));
  };
  const Vec3d o = (d * foot - toCenter) * space.scale;
  return {Vec3(min(max(o, Vec3d(-kFarthest)), Vec3d(kFarthest))), ray_.d, local(range_.t0),
          local(range_.t1), space.strongest * space.scale};
}

void RayReceiver::Local::see(const LightClusters& clusters, ClusterViews& views) const {
  if (hasAvx2())
    avx2::seeFromRay(*this, clusters, views);
  else
    generic::seeFromRay(*this, clusters, views);
}

/// Splits sets of lights until one is left, then joins the nodes of that tree by eights.
class LightTree::Builder {
 public:
  struct Item {
    LightBounds bounds;
    std::uint32_t light;
  };
  Builder(LightTree& tree, std::span<Item> items) : tree_(tree) {
    binary_.reserve(2 * items.size());
    build(items);
    const LightBounds& all = binary_[0].bounds;
    const double radius = 0.5 * length(Vec3d(all.box.hi) - Vec3d(all.box.lo));
    double strongest = 0;
    for (const Item& item : items) strongest = std::max(strongest, item.bounds.intensity);
    tree.space_ = {Vec3d(all.box.center()), radius > 0 ? 1 / radius : 1, strongest};
    join(0, kNone, 0);
  }

 private:
  static constexpr int kBuckets = 12;
  struct Binary {
    LightBounds bounds;
    std::uint32_t second = kNone;  // the first child follows its parent; none: a leaf
    std::uint32_t light = kNone;   // of a leaf
  };

  void build(std::span<Item> items);
  std::uint32_t join(std::uint32_t binary, std::uint32_t parent, std::uint32_t place);
  std::size_t split(std::span<Item> items, const LightBounds& whole) const;
  static double cost(const LightBounds& bounds);

  LightTree& tree_;
  std::vector<Binary> binary_;
};

void LightTree::Builder::build(std::span<Item> items) {
  LightBounds whole;
  for (const Item& item : items) whole += item.bounds;
  const auto index = static_cast<std::uint32_t>(binary_.size());
  binary_.push_back({whole});
  if (items.size() == 1) {
    binary_[index].light = items[0].light;
    return;
  }
  const std::size_t middle = split(items, whole);
  build(items.first(middle));
  binary_[index].second = static_cast<std::uint32_t>(binary_.size());
  build(items.subspan(middle));
}

/// Makes a node of what stands below one of the binary tree: its children, the widest of which
/// make room for their own until the node is full.
std::uint32_t LightTree::Builder::join(std::uint32_t root, std::uint32_t parent,
                                       std::uint32_t place) {
  std::array<std::uint32_t, kWidth> below{root};
  std::size_t count = 1;
  while (count < kWidth) {
    std::size_t widest = kWidth;
    double most = -1;
    for (std::size_t i = 0; i < count; ++i) {
      const Binary& b = binary_[below[i]];
      const Vec3d diagonal = Vec3d(b.bounds.box.hi) - Vec3d(b.bounds.box.lo);
      if (b.light != kNone || !(dot(diagonal, diagonal) > most)) continue;
      most = dot(diagonal, diagonal);
      widest = i;
    }
    if (widest == kWidth) break;
    below[count++] = binary_[below[widest]].second;
    ++below[widest];
  }

  const auto index = static_cast<std::uint32_t>(tree_.nodes_.size());
  tree_.nodes_.emplace_back();
  tree_.nodes_[index].parent = parent;
  tree_.nodes_[index].place = place;
  tree_.nodes_[index].count = static_cast<std::uint32_t>(count);
  const LightTreeSpace& space = tree_.space_;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Binary& b = binary_[below[i]];
    tree_.nodes_[index].clusters.set(i, b.bounds, space.center, space.scale, space.strongest);
    if (b.light != kNone) {
      tree_.nodes_[index].isLight |= 1u << i;
      tree_.nodes_[index].child[i] = b.light;
      tree_.leafOf_[b.light] = index * static_cast<std::uint32_t>(kWidth) + i;
    } else {
      const std::uint32_t child = join(below[i], index, i);
      tree_.nodes_[index].child[i] = child;
    }
  }
  return index;
}

/// Surface area orientation heuristic: intensity times the measure of the directions times the
/// square of the diagonal, in place of the area, so that lights on a line have a size.
double LightTree::Builder::cost(const LightBounds& b) {
  const double axes = std::acos(std::clamp(double{b.axes.cosine}, -1.0, 1.0));
  const double emission = std::acos(std::clamp(double{b.cosEmission}, -1.0, 1.0));
  const double both = std::min(axes + emission, M_PI), sine = std::sin(axes);
  const double directions =
      2 * M_PI * (1 - std::cos(axes)) +
      M_PI_2 * (2 * both * sine - std::cos(axes - 2 * both) - 2 * axes * sine + std::cos(axes));
  const Vec3d diagonal = Vec3d(b.box.hi) - Vec3d(b.box.lo);
  return b.intensity * directions * dot(diagonal, diagonal);
}

/// Reorders the items and returns how many go to the first child: along each axis the centres fall
/// into buckets, and the cheapest border between two of them is taken.
std::size_t LightTree::Builder::split(std::span<Item> items, const LightBounds& whole) const {
  Bounds3 centers;
  for (const Item& item : items) centers.extend(item.bounds.box.center());
  const Vec3 extent = centers.diagonal();
  const auto bucketOf = [&](const Item& item, int axis) {
    const float x = (item.bounds.box.center()[axis] - centers.lo[axis]) / extent[axis];
    return std::clamp(static_cast<int>(x * kBuckets), 0, kBuckets - 1);
  };

  double best = std::numeric_limits<double>::infinity();
  int bestAxis = -1, bestBorder = 0;
  const float longest = maxComponent(whole.box.diagonal());
  for (int axis = 0; axis < 3; ++axis) {
    if (!(extent[axis] > 0)) continue;
    std::array<LightBounds, kBuckets> buckets;
    for (const Item& item : items)
      buckets[static_cast<std::size_t>(bucketOf(item, axis))] += item.bounds;
    // Thin slices are not worth as much as they seem.
    const double thinness = double{longest} / double{std::max(whole.box.diagonal()[axis], 1e-30f)};
    std::array<double, kBuckets> below{}, above{};
    LightBounds left, right;
    for (std::size_t i = 0; i + 1 < kBuckets; ++i) {
      left += buckets[i];
      below[i + 1] = cost(left);
      right += buckets[kBuckets - 1 - i];
      above[kBuckets - 1 - i] = cost(right);
    }
    for (std::size_t border = 1; border < kBuckets; ++border) {
      const double c = thinness * (below[border] + above[border]);
      if (c < best) {
        best = c;
        bestAxis = axis;
        bestBorder = static_cast<int>(border);
      }
    }
  }

  std::size_t middle = items.size() / 2;
  if (bestAxis >= 0) {
    const auto it = std::partition(items.begin(), items.end(), [&](const Item& item) {
      return bucketOf(item, bestAxis) < bestBorder;
    });
    const auto count = static_cast<std::size_t>(it - items.begin());
    if (count > 0 && count < items.size()) middle = count;
  }
  return middle;
}

LightTree::LightTree(std::span<const Light* const> lights, const Options& options)
    : lights_(lights.begin(), lights.end()), evenShare_(options.evenShare) {
  if (options.media && options.media->intensity > 0) lights_.push_back(nullptr);
  irradiance_.resize(lights_.size());
  leafOf_.resize(lights_.size(), kNone);
  std::vector<Builder::Item> items;
  for (std::uint32_t i = 0; i < lights_.size(); ++i) {
    const Light* light = lights_[i];
    hasHittable_ = hasHittable_ || !light || !light->isDelta();
    if (const auto bounds = light ? light->bounds() : options.media) {
      if (bounds->intensity > 0) items.push_back({*bounds, i});
      continue;
    }
    unbounded_.push_back(i);
    irradiance_[i] = std::min(double{light->importance(Bounds3{Vec3(0), Vec3(0)})}, 1e60);
    unboundedIrradiance_ += irradiance_[i];
  }
  slots_.resize(std::bit_ceil(2 * lights_.size() + 1), kNone);
  for (std::uint32_t i = 0; i < lights_.size(); ++i) {
    std::size_t slot = firstSlot(lights_[i]);
    while (slots_[slot] != kNone) slot = (slot + 1) & (slots_.size() - 1);
    slots_[slot] = i;
  }
  if (!items.empty()) Builder(*this, items);
}

std::size_t LightTree::firstSlot(const Light* light) const {
  const std::uint64_t mixed = reinterpret_cast<std::uintptr_t>(light) * 0x9e3779b97f4a7c15ull;
  return static_cast<std::size_t>(mixed >> 32) & (slots_.size() - 1);
}

/// Linear probing in a table that is at most half full.
std::optional<std::uint32_t> LightTree::indexOf(const Light* light) const {
  for (std::size_t slot = firstSlot(light);; slot = (slot + 1) & (slots_.size() - 1)) {
    if (slots_[slot] == kNone) return std::nullopt;
    if (lights_[slots_[slot]] == light) return slots_[slot];
  }
}

template <class Receiver>
auto LightTree::cut(const Receiver& receiver) const -> Cut<Receiver> {
  Cut<Receiver> cut;
  if (lights_.size() == 1) return cut;  // of which nothing is asked
  cut.receiver_ = receiver.in(space_);
  cut.unit_ = cut.receiver_.unit;
  cut.perIrradiance_ = receiver.importance(1);
  cut.unbounded_ = unboundedIrradiance_ * cut.perIrradiance_;
  cut.total_ = cut.unbounded_;
  if (nodes_.empty()) return cut;
  const bool areFew = lights_.size() <= kFewLights;
  cut.nodes_[cut.count_++] = 0;
  for (std::size_t k = 0; k < cut.count_; ++k) {
    const Node& node = nodes_[cut.nodes_[k]];
    ClusterViews views;
    cut.receiver_.see(node.clusters, views);
    double sum = 0;
    for (std::uint32_t i = 0; i < node.count; ++i) {
      const bool isOpened = (node.isLight >> i & 1) == 0 && cut.count_ < kMostOpen &&
                            (areFew || (views.isOutside >> i & 1) == 0);
      if (isOpened) {
        cut.nodes_[cut.count_++] = node.child[i];
        views.importance[i] = 0;
      }
      sum += double{views.importance[i]};
    }
    cut.importance_[k] = views.importance;
    cut.sums_[k] = sum;
    cut.total_ += sum * cut.unit_;
  }
  return cut;
}

/// Walks down from a node: one child by its importance, and what is left of x for the next.
template <class Local>
auto LightTree::descend(const Local& receiver, std::uint32_t index, double x, double p) const
    -> Drawn {
  for (;;) {
    const Node& node = nodes_[index];
    ClusterViews views;
    receiver.see(node.clusters, views);
    double sum = 0;
    for (std::uint32_t i = 0; i < node.count; ++i) sum += double{views.importance[i]};
    if (!(sum > 0)) return {};
    x *= sum;
    std::uint32_t chosen = 0;
    for (std::uint32_t i = 0; i < node.count; ++i) {
      const double importance = double{views.importance[i]};
      if (!(importance > 0)) continue;
      chosen = i;
      if (x < importance) break;
      x -= importance;
    }
    const double importance = double{views.importance[chosen]};
    p *= importance / sum;
    if (node.isLight >> chosen & 1) return {node.child[chosen], p};
    x = std::min(x / importance, 1.0);
    index = node.child[chosen];
  }
}

/// One light by importance alone.
template <class Receiver>
auto LightTree::draw(const Cut<Receiver>& cut, double x) const -> Drawn {
  if (!(cut.total_ > 0)) return {};
  x *= cut.total_;
  if (x < cut.unbounded_) {
    for (std::uint32_t i : unbounded_) {
      const double importance = irradiance_[i] * cut.perIrradiance_;
      if (x < importance) return {i, importance / cut.total_};
      x -= importance;
    }
    return {};
  }
  x = (x - cut.unbounded_) / cut.unit_;
  for (std::size_t k = 0; k < cut.count_; ++k) {
    if (!(x < cut.sums_[k])) {
      x -= cut.sums_[k];
      continue;
    }
    const Node& node = nodes_[cut.nodes_[k]];
    for (std::uint32_t i = 0; i < node.count; ++i) {
      const double importance = double{cut.importance_[k][i]};
      if (x < importance) {
        const double p = importance * cut.unit_ / cut.total_;
        if (node.isLight >> i & 1) return {node.child[i], p};
        return descend(cut.receiver_, node.child[i], x / importance, p);
      }
      x -= importance;
    }
  }
  return {};
}

template <class Receiver>
double LightTree::probabilityByImportance(const Cut<Receiver>& cut, std::uint32_t light) const {
  if (!(cut.total_ > 0)) return 0;
  if (leafOf_[light] == kNone) return irradiance_[light] * cut.perIrradiance_ / cut.total_;
  // From the leaf up to an opened node; importances vanish as they do on the way down.
  std::uint32_t index = leafOf_[light] / static_cast<std::uint32_t>(kWidth),
                place = leafOf_[light] % static_cast<std::uint32_t>(kWidth);
  double p = 1;
  for (;;) {
    for (std::size_t k = 0; k < cut.count_; ++k)
      if (cut.nodes_[k] == index)
        return p * double{cut.importance_[k][place]} * cut.unit_ / cut.total_;
    const Node& node = nodes_[index];
    ClusterViews views;
    cut.receiver_.see(node.clusters, views);
    if (!(views.importance[place] > 0)) return 0;
    double sum = 0;
    for (std::uint32_t i = 0; i < node.count; ++i) sum += double{views.importance[i]};
    p *= double{views.importance[place]} / sum;
    index = node.parent;
    place = node.place;
  }
}

template <class Receiver>
std::optional<LightTree::Choice> LightTree::choose(const Cut<Receiver>& cut, float u) const {
  if (lights_.empty()) return std::nullopt;
  if (lights_.size() == 1) return Choice{lights_[0], 1.f};
  const double n = static_cast<double>(lights_.size()), even = evenShare_ / n;
  const auto choice = [&](std::uint32_t light, double byImportance) {
    return Choice{lights_[light], static_cast<float>(even + (1 - evenShare_) * byImportance)};
  };
  if (double{u} < evenShare_) {
    const auto light = static_cast<std::uint32_t>(std::min(double{u} / even, n - 1));
    return choice(light, probabilityByImportance(cut, light));
  }
  const Drawn drawn = draw(cut, (double{u} - evenShare_) / (1 - evenShare_));
  if (drawn.light == kNone) return std::nullopt;
  return choice(drawn.light, drawn.probability);
}

template <class Receiver>
float LightTree::probability(const Cut<Receiver>& cut, const Light* light) const {
  const auto index = indexOf(light);
  if (!index) return 0.f;
  if (lights_.size() == 1) return 1.f;
  return static_cast<float>(evenShare_ / static_cast<double>(lights_.size()) +
                            (1 - evenShare_) * probabilityByImportance(cut, *index));
}

template LightTree::Cut<PointReceiver> LightTree::cut(const PointReceiver&) const;
template LightTree::Cut<RayReceiver> LightTree::cut(const RayReceiver&) const;
template std::optional<LightTree::Choice> LightTree::choose(const Cut<PointReceiver>&, float) const;
template std::optional<LightTree::Choice> LightTree::choose(const Cut<RayReceiver>&, float) const;
template float LightTree::probability(const Cut<PointReceiver>&, const Light*) const;
template float LightTree::probability(const Cut<RayReceiver>&, const Light*) const;

}  // namespace brume
