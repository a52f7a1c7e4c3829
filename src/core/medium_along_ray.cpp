// SPDX-License-Identifier: Apache-2.0
#include "core/medium_along_ray.h"

#include <algorithm>

#include "core/cubic_density.h"

namespace brume {

namespace {

Vec3d toDouble(const Rgb& c) { return {c.r, c.g, c.b}; }

/// Beyond this optical depth exp(-tau) is below 1e-17 of what was emitted before it.
constexpr double kOpaqueDepth = 40;
/// Optical depth and exponent of the density over one Gauss-Legendre interval: the remainder of the
/// eight-point rule is then below 1e-12.
constexpr double kGaussInterval = 1;

}  // namespace

void MediumAlongRay::assign(const Volume& volume, const Ray& ray, Interval range) {
  ray_ = ray;
  range_ = range;
  maxAlbedo_ = Rgb();
  isGrey_ = true;
  isTracked_ = false;
  pieces_.clear();
  indices_.clear();
  spans_.clear();
  total_ = Vec3d(0);
  if (range.isEmpty()) return;
  volume.appendPieces(ray, range, pieces_);

  findMaxAlbedo();
  bool overlaps = false;
  for (std::size_t i = 1; i < pieces_.size() && !overlaps; ++i)
    overlaps = pieces_[i].t0 < pieces_[i - 1].t1;
  if (overlaps) {
    sweepOverlaps();
    accumulateDepths();
    return;
  }

  // One region alone: its pieces are the spans.
  indices_.resize(pieces_.size());
  spans_.resize(pieces_.size());
  const MediumCoefficients* unit = nullptr;
  Vec3d sigma_t(0);
  for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
    const MediumPiece& p = pieces_[i];
    if (p.unit != unit) {
      unit = p.unit;
      sigma_t = toDouble(unit->sigma_t());
    }
    indices_[i] = i;
    spans_[i] = {p.t0, p.t1, i, 1, total_, Vec3d(0)};
    if (!isTracked_) total_ += sigma_t * p.integral(p.t0, p.t1);
  }
  if (isTracked_) accumulateDepths();
}

void MediumAlongRay::findMaxAlbedo() {
  // The albedo of a sum lies between those of its parts.
  const MediumCoefficients* last = nullptr;
  for (const MediumPiece& p : pieces_) {
    if (p.unit == last) continue;
    last = p.unit;
    isTracked_ |= p.tracked != nullptr;
    const Rgb sigma_t = last->sigma_t();
    isGrey_ &= sigma_t.r == sigma_t.g && sigma_t.g == sigma_t.b;
    for (int c = 0; c < 3; ++c)
      if (sigma_t[c] > 0) maxAlbedo_[c] = std::max(maxAlbedo_[c], last->sigma_s[c] / sigma_t[c]);
  }
}

Interval MediumAlongRay::occupied() const {
  if (spans_.empty()) return {range_.t1, range_.t1};
  const auto t0 = static_cast<float>(spans_.front().t0), t1 = static_cast<float>(spans_.back().t1);
  return {std::max(range_.t0, std::nextafter(t0, -kInfinity)),
          std::min(range_.t1, std::nextafter(t1, kInfinity))};
}

void MediumAlongRay::sweepOverlaps() {
  // All ends cut the ray; between two cuts the set of active pieces is constant.
  cuts_.clear();
  byStart_.resize(pieces_.size());
  for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
    cuts_.push_back(pieces_[i].t0);
    cuts_.push_back(pieces_[i].t1);
    byStart_[i] = i;
  }
  std::sort(cuts_.begin(), cuts_.end());
  cuts_.erase(std::unique(cuts_.begin(), cuts_.end()), cuts_.end());
  std::sort(byStart_.begin(), byStart_.end(), [this](std::uint32_t a, std::uint32_t b) {
    return pieces_[a].t0 != pieces_[b].t0 ? pieces_[a].t0 < pieces_[b].t0 : a < b;
  });

  active_.clear();
  std::size_t next = 0;
  for (std::size_t i = 0; i + 1 < cuts_.size(); ++i) {
    const double a = cuts_[i], b = cuts_[i + 1];
    std::erase_if(active_, [&](std::uint32_t p) { return pieces_[p].t1 <= a; });
    while (next < byStart_.size() && pieces_[byStart_[next]].t0 <= a) {
      if (pieces_[byStart_[next]].t1 > a) active_.push_back(byStart_[next]);
      ++next;
    }
    if (active_.empty()) continue;
    spans_.push_back({a, b, static_cast<std::uint32_t>(indices_.size()),
                      static_cast<std::uint32_t>(active_.size()), Vec3d(0), Vec3d(0)});
    indices_.insert(indices_.end(), active_.begin(), active_.end());
  }
}

void MediumAlongRay::accumulateDepths() {
  for (Span& s : spans_) {
    s.depth = total_;
    s.jump = isTracked_ ? jumpAtStart(s) : Vec3d(0);
    total_ += s.jump + depthBetween(s, s.t0, s.t1);
  }
}

Vec3d MediumAlongRay::jumpAtStart(const Span& s) const {
  Vec3d sum(0);
  for (std::uint32_t i = 0; i < s.count; ++i) {
    const MediumPiece& p = piece(s, i);
    if (p.tracked && p.t0 == s.t0) sum += Vec3d(p.c[0], p.c[1], p.c[2]);
  }
  return sum;
}

Vec3d MediumAlongRay::depthBetween(const Span& s, double a, double b) const {
  Vec3d sum(0);
  for (std::uint32_t i = 0; i < s.count; ++i) {
    const MediumPiece& p = piece(s, i);
    sum += toDouble(p.unit->sigma_t()) * p.integral(a, b);
  }
  return sum;
}

double MediumAlongRay::depthBetween(const Span& s, int channel, double a, double b) const {
  double sum = 0;
  for (std::uint32_t i = 0; i < s.count; ++i) {
    const MediumPiece& p = piece(s, i);
    sum += double{p.unit->sigma_t()[channel]} * p.integral(a, b);
  }
  return sum;
}

double MediumAlongRay::extinction(const Span& s, int channel, double t) const {
  double sum = 0;
  for (std::uint32_t i = 0; i < s.count; ++i) {
    const MediumPiece& p = piece(s, i);
    sum += double{p.unit->sigma_t()[channel]} * p.density(t);
  }
  return sum;
}

Vec3d MediumAlongRay::depthAt(double t) const {
  // The last span that starts before t.
  auto it = std::upper_bound(spans_.begin(), spans_.end(), t,
                             [](double value, const Span& s) { return value < s.t0; });
  if (it == spans_.begin()) return Vec3d(0);
  --it;
  if (t >= it->t1) return it + 1 == spans_.end() ? total_ : (it + 1)->depth;
  if (t == it->t0) return it->depth;
  return it->depth + it->jump + depthBetween(*it, it->t0, t);
}

MediumCoefficients MediumAlongRay::at(float t) const {
  // A t that was rounded to float just out of a span still belongs to it.
  const double slack = std::abs(double{t}) * 4 * double{kMachineEpsilon};
  auto it = std::upper_bound(spans_.begin(), spans_.end(), double{t} + slack,
                             [](double value, const Span& s) { return value < s.t0; });
  MediumCoefficients sum;
  if (it == spans_.begin()) return sum;
  --it;
  if (it != spans_.begin() && double{t} <= (it - 1)->t1) --it;
  if (double{t} > it->t1 + slack) return sum;
  const double inside = std::clamp(double{t}, it->t0, it->t1);
  for (std::uint32_t i = 0; i < it->count; ++i) {
    const MediumPiece& p = piece(*it, i);
    sum += *p.unit * static_cast<float>(density(p, inside));
  }
  return sum;
}

std::optional<double> MediumAlongRay::invert(int channel, double depth) const {
  if (spans_.empty() || !(depth <= total_[channel])) return std::nullopt;
  // The first span at whose end the depth is reached.
  const auto endDepth = [&](std::size_t i) {
    return i + 1 < spans_.size() ? spans_[i + 1].depth[channel] : total_[channel];
  };
  std::size_t lo = 0, hi = spans_.size() - 1;
  while (lo < hi) {
    const std::size_t middle = (lo + hi) / 2;
    if (endDepth(middle) >= depth)
      hi = middle;
    else
      lo = middle + 1;
  }
  const Span& s = spans_[lo];
  const double s0 = s.depth[channel] + s.jump[channel];
  if (depth <= s0) return s.t0;
  const MediumPiece& p = piece(s, 0);
  if (s.count == 1 && p.form == MediumPiece::Form::Cubic && s.t0 == p.t0 && s.t1 == p.t1) {
    const double sigma_t = p.unit->sigma_t()[channel];
    return p.t0 + invertCubic(p, (depth - s0) / sigma_t, p.integral(p.t0, p.t1));
  }
  const double t =
      s.t0 + invertMonotone([&](double x) { return depthBetween(s, channel, s.t0, s.t0 + x); },
                            [&](double x) { return extinction(s, channel, s.t0 + x); }, s.t1 - s.t0,
                            depth - s0, depthBetween(s, channel, s.t0, s.t1));
  return std::min(t, s.t1);
}

Rgb MediumAlongRay::emission() const {
  Vec3d sum(0);
  for (const Span& s : spans_) {
    if (s.count > 1) {
      sum += emissionOfOverlap(s);
      continue;
    }
    // Le and sigma_t share one density rho: Int exp(-sigma_t D) Le rho dt = Le (1 - exp(-sigma_t
    // D)) / sigma_t with D = Int rho dt.
    const MediumPiece& p = piece(s, 0);
    if (p.unit->Le.isBlack()) continue;
    const double density = p.integral(s.t0, s.t1);
    const Rgb sigma_t = p.unit->sigma_t();
    for (int c = 0; c < 3; ++c)
      sum[c] += std::exp(-s.depth[c] - s.jump[c]) * double{p.unit->Le[c]} * density *
                exponentialMean(double{sigma_t[c]} * density);
  }
  return toFloat(sum);
}

double MediumAlongRay::secondMomentOfEmission() const {
  // Three Gauss points are exact for a cubic density; exponential ones are cut into intervals over
  // which they change by no more than e, with a remainder below 1e-6 of each.
  static const double kNode = std::sqrt(0.6);
  double sum = 0;
  for (const MediumPiece& p : pieces_) {
    const double weight = double{p.unit->Le.luminance()};
    if (weight == 0) continue;
    double t0 = p.t0, t1 = p.t1;
    int intervals = 1;
    if (p.form == MediumPiece::Form::Exponential && p.c[1] != 0) {
      // Beyond kOpaqueDepth decays from the denser end nothing is left.
      const double k = p.c[1], longest = kOpaqueDepth / std::abs(k);
      if (t1 - t0 > longest) (k > 0 ? t1 : t0) = k > 0 ? t0 + longest : t1 - longest;
      intervals = 1 + static_cast<int>(std::abs(k) * (t1 - t0));
    }
    const double half = 0.5 * (t1 - t0) / intervals;
    double integral = 0;
    for (int i = 0; i < intervals; ++i) {
      const double middle = t0 + (2 * i + 1) * half, a = middle - half * kNode,
                   b = middle + half * kNode;
      integral += (5 * (sqr(a) * p.density(a) + sqr(b) * p.density(b)) +
                   8 * sqr(middle) * p.density(middle)) /
                  9;
    }
    sum += weight * half * integral;
  }
  return sum;
}

Vec3d MediumAlongRay::emissionOfOverlap(const Span& s) const {
  bool emits = false;
  for (std::uint32_t i = 0; i < s.count; ++i) emits |= !piece(s, i).unit->Le.isBlack();
  if (!emits) return Vec3d(0);

  // Halve the interval until it is thin and smooth; what lies behind an opaque stretch is dropped.
  struct Part {
    double a, b;
    int level;
  };
  std::array<Part, 128> stack;
  std::size_t top = 0;
  stack[top++] = {s.t0, s.t1, 0};
  const Vec3d start = s.depth + s.jump;
  Vec3d depth = start, sum(0);
  while (top > 0) {
    const Part part = stack[--top];
    const Vec3d delta = depthBetween(s, part.a, part.b);
    bool split = false;
    bool visible = false;
    for (int c = 0; c < 3; ++c) {
      const bool reached = depth[c] - start[c] < kOpaqueDepth;
      split |= reached && delta[c] > kGaussInterval;
      visible |= reached;
    }
    for (std::uint32_t i = 0; visible && i < s.count; ++i) {
      const MediumPiece& p = piece(s, i);
      split |= p.form == MediumPiece::Form::Exponential &&
               std::abs(p.c[1]) * (part.b - part.a) > kGaussInterval;
    }
    const double middle = 0.5 * (part.a + part.b);
    if (split && part.level < 60 && middle > part.a && middle < part.b) {
      stack[top++] = {middle, part.b, part.level + 1};
      stack[top++] = {part.a, middle, part.level + 1};
      continue;
    }
    if (visible) sum += emissionByGauss(s, part.a, part.b, depth);
    depth += delta;
  }
  return sum;
}

Vec3d MediumAlongRay::emissionByGauss(const Span& s, double a, double b,
                                      const Vec3d& depthAtA) const {
  constexpr std::array<double, 4> kNode = {0.18343464249564980, 0.52553240991632899,
                                           0.79666647741362674, 0.96028985649753623};
  constexpr std::array<double, 4> kWeight = {0.36268378337836198, 0.31370664587788729,
                                             0.22238103445337447, 0.10122853629037626};
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  Vec3d sum(0);
  for (int i = 0; i < 8; ++i) {
    const double t = middle + half * (i < 4 ? -kNode[i] : kNode[i - 4]);
    const Vec3d depth = depthAtA + depthBetween(s, a, t);
    Vec3d source(0);
    for (std::uint32_t k = 0; k < s.count; ++k)
      source += toDouble(piece(s, k).unit->Le) * piece(s, k).density(t);
    for (int c = 0; c < 3; ++c) sum[c] += kWeight[i & 3] * half * source[c] * std::exp(-depth[c]);
  }
  return sum;
}

}  // namespace brume
