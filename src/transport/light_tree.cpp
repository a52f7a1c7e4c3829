// SPDX-License-Identifier: Apache-2.0
#include "transport/light_tree.h"

#include "core/error.h"

namespace brume {
namespace {

/// Radii and angles are widened by this, so that rounding never cuts a light off.
constexpr double kSlack = 1e-5;
/// Share of r^2 that is added to the squared distance from a cluster's centre.
constexpr double kSpread = 0.1;
/// Nodes of a cut through the tree.
constexpr std::size_t kMostNodes = 32;
/// Up to this number of lights all nodes are opened.
constexpr std::size_t kFewLights = 16;
/// Light at the border of a cluster's emission still counts this much.
constexpr double kLeastFalloff = 0.05;

/// An angle in [0, pi] by its cosine and sine.
struct Angle {
  double cos = 1, sin = 0;
  static Angle ofCosine(double c) {
    c = std::clamp(c, -1.0, 1.0);
    return {c, std::sqrt(1 - c * c)};
  }
  static Angle ofSine(double s) { return {std::sqrt(std::max(0.0, 1 - s * s)), s}; }
};
/// max(0, a - b)
Angle minus(const Angle& a, const Angle& b) {
  if (a.cos >= b.cos) return {};
  return {a.cos * b.cos + a.sin * b.sin, a.sin * b.cos - a.cos * b.sin};
}

/// About the angle of (x, y), y >= 0, to within 0.3 %: whatever it is, it is the same whenever a
/// probability is asked for.
double roughAngle(double y, double x) {
  const double a = std::abs(x), small = std::min(a, y), large = std::max(a, y);
  const double q = large > 0 ? small / large : 0;
  double angle = q * (M_PI_4 + 0.273 * (1 - q));
  if (y > a) angle = M_PI_2 - angle;
  return x < 0 ? M_PI - angle : angle;
}

/// Part of a cluster's intensity that may leave it at an angle to its axes; 0 when nothing does.
double falloff(const LightCluster& c, const Angle& toAxes) {
  if (toAxes.cos + kSlack < double{c.cosEmission}) return 0;
  return c.cosEmission >= 0 ? std::max(toAxes.cos, kLeastFalloff) : 1;
}

}  // namespace

std::vector<const Light*> emittingLights(const Scene& scene) {
  std::vector<const Light*> result;
  for (const auto& light : scene.lights())
    if (!light->power().isBlack()) result.push_back(light.get());
  return result;
}

LightCluster::LightCluster(const LightBounds& bounds)
    : center(bounds.box.center()),
      radius(static_cast<float>(0.5 * length(Vec3d(bounds.box.hi) - Vec3d(bounds.box.lo)) *
                                (1 + kSlack))),
      axis(bounds.axes.axis),
      cosAxes(bounds.axes.cosine),
      sinAxes(safeSqrt(1 - sqr(bounds.axes.cosine))),
      cosEmission(bounds.cosEmission),
      // Finite, so that sums are; and so small a part of double's range that no quotient overflows.
      intensity(std::min(bounds.intensity, 1e60)) {}

ClusterView PointReceiver::see(const LightCluster& c) const {
  const Vec3d d = Vec3d(c.center) - p_;
  const double d2 = dot(d, d), r2 = sqr(double{c.radius});
  double value = c.intensity / std::max(d2 + kSpread * r2, 1e-60);
  if (d2 <= r2) return {value, true};
  const bool isEverything = c.cosAxes <= -1;
  if (isEverything && !hasNormal_) return {value};

  const double l = std::sqrt(d2);
  const Angle ball = Angle::ofSine(double{c.radius} / l);
  if (!isEverything) {
    const Angle axis = Angle::ofCosine(-dot(Vec3d(c.axis), d) / l);
    value *= falloff(c, minus(minus(axis, {double{c.cosAxes}, double{c.sinAxes}}), ball));
  }
  if (hasNormal_)
    value *= std::max(minus(Angle::ofCosine(std::abs(dot(n_, d)) / l), ball).cos, kSlack);
  return {value};
}

RayReceiver::RayReceiver(const Ray& ray, Interval range)
    : o_(ray.o), d_(ray.d), t0_(double{range.t0}), t1_(double{range.t1}) {}

ClusterView RayReceiver::see(const LightCluster& c) const {
  const Vec3d toCenter = Vec3d(c.center) - o_;
  const double foot = dot(toCenter, d_), a = t0_ - foot, b = t1_ - foot, r2 = sqr(double{c.radius});
  const Vec3d offset = toCenter - d_ * foot;
  const double aside2 = dot(offset, offset), reach = std::max(std::abs(a), std::abs(b));
  const double D = std::sqrt(std::max({aside2 + kSpread * r2, sqr(1e-6 * reach), 1e-60}));
  const double value = c.intensity * roughAngle(D * (b - a), D * D + a * b) / D;

  const double nearest = a > 0 ? a : b < 0 ? b : 0, nearest2 = aside2 + nearest * nearest;
  if (nearest2 <= r2) return {value, true};
  if (c.cosAxes <= -1) return {value};
  // The directions from the centre to the stretch fill an arc; from the ball, a cone around it.
  const Vec3d sum = normalize(d_ * a - offset) + normalize(d_ * b - offset);
  const double l = length(sum);
  if (l < 1e-3) return {value};
  const Angle axis = Angle::ofCosine(dot(Vec3d(c.axis), sum) / l);
  const Angle toAxes =
      minus(minus(minus(axis, {double{c.cosAxes}, double{c.sinAxes}}), Angle::ofCosine(0.5 * l)),
            Angle::ofSine(std::sqrt(r2 / nearest2)));
  return {value * falloff(c, toAxes)};
}

/// Splits sets of lights until one is left.
class LightTree::Builder {
 public:
  struct Item {
    LightBounds bounds;
    std::uint32_t light;
  };
  Builder(LightTree& tree, std::span<Item> items) : tree_(tree) {
    tree.nodes_.reserve(2 * items.size());
    build(items, kNone);
  }

 private:
  static constexpr int kBuckets = 12;

  void build(std::span<Item> items, std::uint32_t parent);
  std::size_t split(std::span<Item> items, const LightBounds& whole) const;
  static double cost(const LightBounds& bounds);

  LightTree& tree_;
};

void LightTree::Builder::build(std::span<Item> items, std::uint32_t parent) {
  LightBounds whole;
  for (const Item& item : items) whole += item.bounds;
  const auto index = static_cast<std::uint32_t>(tree_.nodes_.size());
  tree_.nodes_.push_back({LightCluster(whole), parent});
  if (items.size() == 1) {
    tree_.nodes_[index].light = items[0].light;
    tree_.leafOf_[items[0].light] = index;
    return;
  }
  const std::size_t middle = split(items, whole);
  build(items.first(middle), index);
  tree_.nodes_[index].second = static_cast<std::uint32_t>(tree_.nodes_.size());
  build(items.subspan(middle), index);
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
    sorted_.emplace_back(light, i);
    hasHittable_ = hasHittable_ || !light || !light->isDelta();
    if (const auto bounds = light ? light->bounds() : options.media) {
      if (bounds->intensity > 0) items.push_back({*bounds, i});
      continue;
    }
    unbounded_.push_back(i);
    irradiance_[i] = std::min(double{light->importance(Bounds3{Vec3(0), Vec3(0)})}, 1e60);
    unboundedIrradiance_ += irradiance_[i];
  }
  std::sort(sorted_.begin(), sorted_.end());
  if (!items.empty()) Builder(*this, items);
}

std::optional<std::uint32_t> LightTree::indexOf(const Light* light) const {
  const auto it = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair{light, 0u});
  if (it == sorted_.end() || it->first != light) return std::nullopt;
  return it->second;
}

/// Nodes that hold every light once, in the order of the tree, with their importance. The same for
/// the same receiver.
struct LightTree::Cut {
  std::array<std::uint32_t, kMostNodes> nodes;
  std::array<double, kMostNodes> importance;
  std::size_t count = 0;
  double unbounded = 0, total = 0;

  /// The node that holds a leaf: indices grow along the tree.
  std::size_t holder(std::uint32_t leaf) const {
    std::size_t i = 0;
    while (i + 1 < count && nodes[i + 1] <= leaf) ++i;
    return i;
  }
};

template <class Receiver>
void LightTree::makeCut(const Receiver& receiver, Cut& cut) const {
  cut.total = cut.unbounded = unbounded_.empty() ? 0 : receiver.importance(unboundedIrradiance_);
  if (nodes_.empty()) return;
  const bool areFew = lights_.size() <= kFewLights;
  std::array<std::uint32_t, kMostNodes> stack;
  std::size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const std::uint32_t index = stack[--waiting];
    const Node& node = nodes_[index];
    const ClusterView view = receiver.see(node.cluster);
    if (node.light == kNone && (view.isInside || areFew) && cut.count + waiting + 2 <= kMostNodes) {
      stack[waiting++] = node.second;
      stack[waiting++] = index + 1;
      continue;
    }
    cut.nodes[cut.count] = index;
    cut.importance[cut.count++] = view.importance;
    cut.total += view.importance;
  }
}

/// Walks down from a node: one child by its importance, and what is left of x for the next.
template <class Receiver>
auto LightTree::descend(const Receiver& receiver, std::uint32_t node, double x, double p) const
    -> Drawn {
  while (nodes_[node].light == kNone) {
    const double first = receiver.see(nodes_[node + 1].cluster).importance,
                 second = receiver.see(nodes_[nodes_[node].second].cluster).importance;
    const double sum = first + second;
    if (!(sum > 0)) return {};
    const double share = first / sum;
    if (x < share) {
      x /= share;
      p *= share;
      node = node + 1;
    } else {
      x = (x - share) / (second / sum);
      p *= second / sum;
      node = nodes_[node].second;
    }
  }
  return {nodes_[node].light, p};
}

/// One light by importance alone.
template <class Receiver>
auto LightTree::draw(const Receiver& receiver, double x) const -> Drawn {
  Cut cut;
  makeCut(receiver, cut);
  if (!(cut.total > 0)) return {};
  x *= cut.total;
  if (x < cut.unbounded) {
    for (std::uint32_t i : unbounded_) {
      const double importance = receiver.importance(irradiance_[i]);
      if (x < importance) return {i, importance / cut.total};
      x -= importance;
    }
    return {};
  }
  x -= cut.unbounded;
  for (std::size_t i = 0; i < cut.count; ++i) {
    if (x < cut.importance[i])
      return descend(receiver, cut.nodes[i], x / cut.importance[i], cut.importance[i] / cut.total);
    x -= cut.importance[i];
  }
  return {};
}

template <class Receiver>
double LightTree::probabilityByImportance(const Receiver& receiver, std::uint32_t light) const {
  Cut cut;
  makeCut(receiver, cut);
  if (!(cut.total > 0)) return 0;
  std::uint32_t node = leafOf_[light];
  if (node == kNone) return receiver.importance(irradiance_[light]) / cut.total;
  const std::size_t holder = cut.holder(node);
  double p = cut.importance[holder] / cut.total;
  // From the leaf up; importances vanish as they do on the way down.
  while (node != cut.nodes[holder]) {
    const std::uint32_t parent = nodes_[node].parent, second = nodes_[parent].second;
    const double own = receiver.see(nodes_[node].cluster).importance,
                 other =
                     receiver.see(nodes_[node == second ? parent + 1 : second].cluster).importance;
    if (!(own > 0)) return 0;
    p *= own / (own + other);
    node = parent;
  }
  return p;
}

template <class Receiver>
std::optional<LightTree::Choice> LightTree::choose(const Receiver& receiver, float u) const {
  if (lights_.empty()) return std::nullopt;
  if (lights_.size() == 1) return Choice{lights_[0], 1.f};
  const double n = static_cast<double>(lights_.size()), even = evenShare_ / n;
  const auto choice = [&](std::uint32_t light, double byImportance) {
    return Choice{lights_[light], static_cast<float>(even + (1 - evenShare_) * byImportance)};
  };
  if (double{u} < evenShare_) {
    const auto light = static_cast<std::uint32_t>(std::min(double{u} / even, n - 1));
    return choice(light, probabilityByImportance(receiver, light));
  }
  const Drawn drawn = draw(receiver, (double{u} - evenShare_) / (1 - evenShare_));
  if (drawn.light == kNone) return std::nullopt;
  return choice(drawn.light, drawn.probability);
}

template <class Receiver>
float LightTree::probability(const Receiver& receiver, const Light* light) const {
  const auto index = indexOf(light);
  if (!index) return 0.f;
  if (lights_.size() == 1) return 1.f;
  return static_cast<float>(evenShare_ / static_cast<double>(lights_.size()) +
                            (1 - evenShare_) * probabilityByImportance(receiver, *index));
}

template std::optional<LightTree::Choice> LightTree::choose(const PointReceiver&, float) const;
template std::optional<LightTree::Choice> LightTree::choose(const RayReceiver&, float) const;
template float LightTree::probability(const PointReceiver&, const Light*) const;
template float LightTree::probability(const RayReceiver&, const Light*) const;

}  // namespace brume
