// SPDX-License-Identifier: Apache-2.0
#include "transport/depth_tables.h"

#include <algorithm>

namespace brume {
namespace {

/// A cubic through four even points follows an exponential over this exponent to 3e-7.
constexpr double kExponent = 0.15;
/// Stretches of less optical depth need not follow it.
constexpr double kNoDepth = 1e-7;
constexpr int kMostHalvings = 60;

/// Coefficients of a cubic over [0, 1].
using Cubic = std::array<double, 4>;

Cubic fromBernstein(const std::array<double, 4>& c) {
  return {c[0], 3 * (c[1] - c[0]), 3 * (c[2] - 2 * c[1] + c[0]), c[3] - 3 * c[2] + 3 * c[1] - c[0]};
}

/// Through the values at 0, 1/3, 2/3 and 1.
Cubic through(const std::array<double, 4>& f) {
  return {f[0], 0.5 * (-11 * f[0] + 18 * f[1] - 9 * f[2] + 2 * f[3]),
          0.5 * (18 * f[0] - 45 * f[1] + 36 * f[2] - 9 * f[3]),
          0.5 * (-9 * f[0] + 27 * f[1] - 27 * f[2] + 9 * f[3])};
}

/// The unit that all pieces share, or null.
const MediumCoefficients* sharedUnit(const MediumAlongRay& medium) {
  const MediumCoefficients* unit = nullptr;
  for (const MediumAlongRay::Span& span : medium.spans())
    for (std::uint32_t i = 0; i < span.count; ++i) {
      const MediumCoefficients* const other = medium.piece(span, i).unit;
      if (unit != nullptr && other != unit) return nullptr;
      unit = other;
    }
  return unit;
}

}  // namespace

/// Turns one medium into segments.
class DepthTables::Filler {
 public:
  Filler(const MediumAlongRay& medium, double t0, Table& table,
         std::array<std::vector<DepthSegment>, 3>& curves)
      : medium_(medium), t0_(t0), curves_(curves) {
    for (auto& curve : curves_) curve.clear();
    const MediumCoefficients* const unit = medium.isTracked() ? nullptr : sharedUnit(medium);
    if (unit != nullptr) {
      const Rgb sigma_t = unit->sigma_t();
      table.sigma = {sigma_t.r, sigma_t.g, sigma_t.b};
      table.isGrey = medium.isGrey();
      isUnit_ = true;
    } else {
      table.sigma = {1, 1, 1};
      table.isGrey = medium.isGrey();
      count_ = table.isGrey ? 1 : 3;
    }
    for (const MediumAlongRay::Span& span : medium.spans()) addSpan(span);
    if (curves_[0].empty())
      for (std::size_t k = 0; k < count_; ++k) curves_[k].push_back({0, 0, 0, 0, {}});
    table.curves = static_cast<std::uint32_t>(count_);
  }

 private:
  double weight(const MediumPiece& piece, std::size_t curve) const {
    return isUnit_ ? 1.0 : double{piece.unit->sigma_t()[static_cast<int>(curve)]};
  }

  void addSpan(const MediumAlongRay::Span& span) {
    if (medium_.isTracked())
      for (std::size_t k = 0; k < count_; ++k) depth_[k] += span.jump[static_cast<int>(k)];
    const MediumPiece& first = medium_.piece(span, 0);
    if (span.count == 1 && first.form == MediumPiece::Form::Cubic) {
      const Cubic cubic = fromBernstein(first.c);
      std::array<Cubic, 3> of{};
      for (std::size_t k = 0; k < count_; ++k)
        for (std::size_t i = 0; i < 4; ++i) of[k][i] = weight(first, k) * cubic[i];
      append(span.t0, span.t1, of);
      return;
    }
    addStretch(span, span.t0, span.t1, 0);
  }

  /// Halves the stretch until a cubic follows what is exponential in it.
  void addStretch(const MediumAlongRay::Span& span, double a, double b, int halvings) {
    double steepest = 0, depth = 0;
    for (std::uint32_t i = 0; i < span.count; ++i) {
      const MediumPiece& piece = medium_.piece(span, i);
      if (piece.form == MediumPiece::Form::Exponential)
        steepest = std::max(steepest, std::abs(piece.c[1]));
      depth += double{piece.unit->sigma_t().maxChannel()} * piece.integral(a, b);
    }
    const double middle = 0.5 * (a + b);
    if (steepest * (b - a) > kExponent && depth > kNoDepth && halvings < kMostHalvings &&
        middle > a && middle < b) {
      addStretch(span, a, middle, halvings + 1);
      addStretch(span, middle, b, halvings + 1);
      return;
    }
    std::array<Cubic, 3> of{};
    for (std::size_t k = 0; k < count_; ++k) {
      std::array<double, 4> f{};
      for (std::uint32_t i = 0; i < span.count; ++i) {
        const MediumPiece& piece = medium_.piece(span, i);
        for (int j = 0; j < 4; ++j)
          f[static_cast<std::size_t>(j)] +=
              weight(piece, k) * piece.density(std::min(b, a + (b - a) * j / 3));
      }
      of[k] = through(f);
    }
    append(a, b, of);
  }

  void append(double a, double b, const std::array<Cubic, 3>& density) {
    const double l = b - a;
    if (!(l > 0)) return;
    const auto s0 = static_cast<float>(a - t0_);
    const auto perLength = static_cast<float>(std::min(1 / l, 1e30));
    for (std::size_t k = 0; k < count_; ++k) {
      const Cubic& p = density[k];
      const Cubic c{l * p[0], l * p[1] / 2, l * p[2] / 3, l * p[3] / 4};
      curves_[k].push_back({s0,
                            static_cast<float>(b - t0_),
                            perLength,
                            static_cast<float>(depth_[k]),
                            {static_cast<float>(c[0]), static_cast<float>(c[1]),
                             static_cast<float>(c[2]), static_cast<float>(c[3])}});
      depth_[k] += c[0] + c[1] + c[2] + c[3];
    }
  }

  const MediumAlongRay& medium_;
  double t0_;
  std::array<std::vector<DepthSegment>, 3>& curves_;
  bool isUnit_ = false;  // D is Int density; else Int sigma_t
  std::size_t count_ = 1;
  std::array<double, 3> depth_{};
};

void DepthTables::reset(std::size_t count) {
  tables_.assign(count, {});
  segments_.clear();
  buckets_.clear();
}

void DepthTables::fill(std::size_t index, const MediumAlongRay& medium, float t0) {
  thread_local std::array<std::vector<DepthSegment>, 3> curves;  // reused, so that its memory is
  if (segments_.size() >= kMostSegments) reset(tables_.size());
  Table& table = tables_[index];
  Filler(medium, double{t0}, table, curves);
  table.first = static_cast<std::uint32_t>(segments_.size());
  table.count = static_cast<std::uint32_t>(curves[0].size());
  table.begin = curves[0].front().s0;
  const float end = curves[0].back().next, length = end - table.begin;
  table.bucketsPerLength = length > 0 ? static_cast<float>(table.count) / length : 0.f;

  for (std::size_t k = 0; k < table.curves; ++k) {
    std::vector<DepthSegment>& curve = curves[k];
    for (std::size_t i = 0; i + 1 < curve.size(); ++i) curve[i].next = curve[i + 1].s0;
    curve.back().next = kInfinity;
    segments_.insert(segments_.end(), curve.begin(), curve.end());
  }
  buckets_.resize(segments_.size());
  std::uint32_t last = 0;
  for (std::uint32_t i = 0; i < table.count; ++i) {
    const float s =
        table.begin + static_cast<float>(i) * (length / static_cast<float>(table.count));
    while (s >= curves[0][last].next) ++last;
    buckets_[table.first + i] = table.first + last;
  }
}

}  // namespace brume
