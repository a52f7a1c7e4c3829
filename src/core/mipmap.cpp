// SPDX-License-Identifier: Apache-2.0
#include "core/mipmap.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>

#include "core/error.h"

namespace brume {
namespace {

constexpr double kMaxPyramidBytes = 0x1p34;
constexpr int kWeightTableSize = 128;

/// exp(-2 r^2) - exp(-2) for r^2 = i / (size - 1).
const std::array<float, kWeightTableSize> kGaussian = [] {
  constexpr float kAlpha = 2.f;
  std::array<float, kWeightTableSize> table{};
  for (int i = 0; i < kWeightTableSize; ++i) {
    const float r2 = static_cast<float>(i) / (kWeightTableSize - 1);
    table[static_cast<std::size_t>(i)] = std::exp(-kAlpha * r2) - std::exp(-kAlpha);
  }
  return table;
}();

int roundUpPow2(int n) { return static_cast<int>(std::bit_ceil(static_cast<unsigned>(n))); }

/// Lanczos-windowed sinc, tau = 2, zero beyond |x| = 1.
float lanczos(float x) {
  x = std::abs(x);
  if (x < 1e-5f) return 1.f;  // the sinc's limit; the error there is below float precision
  if (x > 1.f) return 0.f;
  constexpr float kTau = 2.f;
  x *= kPi;
  return std::sin(x * kTau) / (x * kTau) * (std::sin(x) / x);
}

/// Four source texels and their weights for one target texel.
struct ResampleWeight {
  int first = 0;
  std::array<float, 4> weight{};
};

std::vector<ResampleWeight> resampleWeights(int from, int to) {
  constexpr float kRadius = 2.f;
  std::vector<ResampleWeight> weights(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    const float center =
        (static_cast<float>(i) + .5f) * static_cast<float>(from) / static_cast<float>(to);
    ResampleWeight& w = weights[static_cast<std::size_t>(i)];
    w.first = static_cast<int>(std::floor(center - kRadius + .5f));
    float sum = 0;
    for (int j = 0; j < 4; ++j) {
      const float position = static_cast<float>(w.first + j) + .5f;
      sum += w.weight[static_cast<std::size_t>(j)] = lanczos((position - center) / kRadius);
    }
    for (float& weight : w.weight) weight /= sum;
  }
  return weights;
}

/// The index in [0, n) that i stands for; -1 for none.
int wrapIndex(int i, int n, WrapMode wrap) {
  if (i >= 0 && i < n) return i;
  switch (wrap) {
    case WrapMode::Repeat: {
      const int r = i % n;
      return r < 0 ? r + n : r;
    }
    case WrapMode::Clamp:
      return i < 0 ? 0 : n - 1;
    case WrapMode::Black:
      break;
  }
  return -1;
}

float clampNegative(float v) { return std::max(v, 0.f); }
Rgb clampNegative(const Rgb& v) { return max(v, 0.f); }

/// Along s: from rows of `from` texels to rows of `to`.
template <class T>
std::vector<T> resampleRows(const std::vector<T>& image, int from, int to, int rows, int targetRows,
                            WrapMode wrap) {
  std::vector<T> result(static_cast<std::size_t>(to) * static_cast<std::size_t>(targetRows));
  const std::vector<ResampleWeight> weights = resampleWeights(from, to);
  for (int t = 0; t < rows; ++t) {
    const T* source = image.data() + static_cast<std::size_t>(t) * static_cast<std::size_t>(from);
    T* target = result.data() + static_cast<std::size_t>(t) * static_cast<std::size_t>(to);
    for (const ResampleWeight& w : weights) {
      T sum{};
      for (int j = 0; j < 4; ++j)
        if (const int s = wrapIndex(w.first + j, from, wrap); s >= 0)
          sum += w.weight[static_cast<std::size_t>(j)] * source[s];
      *target++ = sum;
    }
  }
  return result;
}

/// Along t, in place: the first `from` rows become `to` rows. Negative lobes are cut here.
template <class T>
void resampleColumns(std::vector<T>& image, int width, int from, int to, WrapMode wrap) {
  constexpr int kBlock = 16;  // columns at a time, for the cache
  const std::vector<ResampleWeight> weights = resampleWeights(from, to);
  std::vector<T> columns(static_cast<std::size_t>(from) * kBlock);
  const auto w = static_cast<std::size_t>(width);
  for (int s0 = 0; s0 < width; s0 += kBlock) {
    const int n = std::min(kBlock, width - s0);
    for (std::size_t t = 0; t < static_cast<std::size_t>(from); ++t)
      std::copy_n(image.data() + t * w + s0, n, columns.data() + t * kBlock);
    for (std::size_t t = 0; t < static_cast<std::size_t>(to); ++t)
      for (int s = 0; s < n; ++s) {
        T sum{};
        for (int j = 0; j < 4; ++j)
          if (const int row = wrapIndex(weights[t].first + j, from, wrap); row >= 0)
            sum += weights[t].weight[static_cast<std::size_t>(j)] *
                   columns[static_cast<std::size_t>(row) * kBlock + static_cast<std::size_t>(s)];
        image[t * w + static_cast<std::size_t>(s0 + s)] = clampNegative(sum);
      }
  }
}

/// Every second of w x h texels, each the mean of its 2 x 2 (or, beside a side of one texel, 2).
template <class T>
std::vector<T> halve(const std::vector<T>& fine, int w, int h) {
  const int coarseW = std::max(1, w / 2), coarseH = std::max(1, h / 2);
  const int right = w > 1 ? 1 : 0;
  const std::size_t below = h > 1 ? static_cast<std::size_t>(w) : 0;
  std::vector<T> coarse;
  coarse.reserve(static_cast<std::size_t>(coarseW) * static_cast<std::size_t>(coarseH));
  for (int t = 0; t < coarseH; ++t) {
    const T* row = fine.data() + 2 * static_cast<std::size_t>(t) * static_cast<std::size_t>(w);
    for (int s = 0; s < coarseW; ++s, row += 2)
      coarse.push_back(
          .25f * (row[0] + row[right] + row[below] + row[below + static_cast<std::size_t>(right)]));
  }
  return coarse;
}

Vec2 scaled(Vec2 v, int width, int height) {
  return {v.x * static_cast<float>(width), v.y * static_cast<float>(height)};
}

/// Into the range where texel indices fit an int with room to spare; NaN to its lower end.
float toIndexable(float x) {
  constexpr float kFar = 2048.f;
  return x >= -kFar ? std::min(x, kFar) : -kFar;
}

/// For |x| far below 2^31; std::floor is a call on machines without SSE 4.1.
int floorToInt(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}
int ceilToInt(float x) { return -floorToInt(-x); }

}  // namespace

template <class T>
double MipMap<T>::bytes(Vec2i size) {
  return 4. / 3 * sizeof(T) * roundUpPow2(size.x) * roundUpPow2(size.y);
}

template <class T>
bool MipMap<T>::fits(Vec2i size) {
  return bytes(size) <= kMaxPyramidBytes;
}

template <class T>
MipMap<T>::MipMap(int width, int height, std::vector<T> texels, const MipMapSettings& settings)
    : settings_(settings) {
  BRUME_CHECK(width > 0 && height > 0 &&
              texels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const int w = roundUpPow2(width), h = roundUpPow2(height);
  if (!fits({width, height}))
    throw SceneError(fmt::format(
        "the filtered image is too large: {} x {} texels need {:.1f} GiB; the limit is {:.0f} GiB",
        w, h, bytes({width, height}) / 0x1p30, kMaxPyramidBytes / 0x1p30));
  if (w != width || h != height) {
    texels = resampleRows(texels, width, w, height, h, settings.wrap);
    resampleColumns(texels, w, height, h, settings.wrap);
  }
  levels_.push_back({w, h, std::move(texels)});
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse{std::max(1, fine.width / 2), std::max(1, fine.height / 2),
                 halve(fine.texels, fine.width, fine.height)};
    levels_.push_back(std::move(coarse));
  }
}

template <class T>
T MipMap<T>::wrapped(const Level& level, int s, int t) const {
  s = wrapIndex(s, level.width, settings_.wrap);
  t = wrapIndex(t, level.height, settings_.wrap);
  if (s < 0 || t < 0) return T{};
  return level.row(t)[s];
}

template <class T>
T MipMap<T>::texel(int level, int s, int t) const {
  return wrapped(levels_[static_cast<std::size_t>(level)], s, t);
}

template <class T>
Vec2 MipMap<T>::wrapPoint(Vec2 st) const {
  const bool inside = st.x >= 0 && st.x < 1 && st.y >= 0 && st.y < 1;
  if (inside) return st;
  if (settings_.wrap == WrapMode::Repeat) st -= Vec2(std::floor(st.x), std::floor(st.y));
  return {toIndexable(st.x), toIndexable(st.y)};
}

template <class T>
T MipMap<T>::bilinear(const Level& level, Vec2 st) const {
  const Vec2 p = scaled(st, level.width, level.height) - Vec2(.5f);
  const int s = floorToInt(p.x), t = floorToInt(p.y);
  const float ds = p.x - static_cast<float>(s), dt = p.y - static_cast<float>(t);
  const auto blend = [&](const T& v00, const T& v01, const T& v10, const T& v11) {
    return (1 - ds) * (1 - dt) * v00 + (1 - ds) * dt * v01 + ds * (1 - dt) * v10 + ds * dt * v11;
  };
  if (s >= 0 && t >= 0 && s + 1 < level.width && t + 1 < level.height) {
    const T* row = level.row(t);
    const T* next = row + level.width;
    return blend(row[s], next[s], row[s + 1], next[s + 1]);
  }
  return blend(wrapped(level, s, t), wrapped(level, s, t + 1), wrapped(level, s + 1, t),
               wrapped(level, s + 1, t + 1));
}

template <class T>
T MipMap<T>::lookup(Vec2 st, float width) const {
  constexpr float kNarrowest = 1e-8f;
  st = wrapPoint(st);
  const float top = static_cast<float>(levels() - 1);
  const float level = top + std::log2(std::max(width, kNarrowest));
  if (level < 0) return bilinear(levels_[0], st);
  if (!(level < top)) return levels_.back().texels[0];
  const float below = std::floor(level), delta = level - below;
  const auto i = static_cast<std::size_t>(below);
  return (1 - delta) * bilinear(levels_[i], st) + delta * bilinear(levels_[i + 1], st);
}

template <class T>
T MipMap<T>::lookup(Vec2 st, Vec2 dst0, Vec2 dst1) const {
  if (settings_.trilinear)
    return lookup(st, 2 * std::max(std::max(std::abs(dst0.x), std::abs(dst0.y)),
                                   std::max(std::abs(dst1.x), std::abs(dst1.y))));
  // dst0 is the longer axis; a very eccentric ellipse is made thicker, which blurs but bounds the
  // work.
  if (dot(dst0, dst0) < dot(dst1, dst1)) std::swap(dst0, dst1);
  const float longer = std::sqrt(dot(dst0, dst0));
  float shorter = std::sqrt(dot(dst1, dst1));
  if (shorter * settings_.maxAnisotropy < longer && shorter > 0) {
    const float scale = longer / (shorter * settings_.maxAnisotropy);
    dst1 *= scale;
    shorter *= scale;
  }
  // Footprints that overflow see the mean.
  if (!(longer < kInfinity && shorter < kInfinity)) return levels_.back().texels[0];
  st = wrapPoint(st);
  if (shorter == 0) return bilinear(levels_[0], st);

  const float lod = std::max(0.f, static_cast<float>(levels() - 1) + std::log2(shorter));
  if (!(lod < static_cast<float>(levels() - 1))) return levels_.back().texels[0];
  const float below = std::floor(lod), delta = lod - below;
  const auto i = static_cast<std::size_t>(below);
  const T finer = ewa(levels_[i], st, dst0, dst1);
  if (delta == 0) return finer;  // magnified: level 0 alone
  return (1 - delta) * finer + delta * ewa(levels_[i + 1], st, dst0, dst1);
}

/// The weights of the texels of one row in turn: the quadratic r^2(s) by its differences.
template <class T>
class MipMap<T>::RowWeights {
 public:
  RowWeights(float r2, float step, float stepOfStep)
      : index_(r2 * kWeightTableSize),
        step_(step * kWeightTableSize),
        stepOfStep_(stepOfStep * kWeightTableSize) {}
  float next() {
    // The last entry is 0: texels that rounding lets in from outside count nothing.
    constexpr float kLast = kWeightTableSize - 1;
    const float below = index_ < kLast ? index_ : kLast;
    const float index = below > 0.f ? below : 0.f;
    index_ += step_;
    step_ += stepOfStep_;
    return kGaussian[static_cast<std::size_t>(static_cast<int>(index))];
  }

 private:
  float index_, step_, stepOfStep_;
};

template <class T>
inline void MipMap<T>::accumulateRow(const Level& level, int t, int s0, int s1, RowWeights weights,
                                     T& sum, float& sumWeights) const {
  const int row = wrapIndex(t, level.height, settings_.wrap);
  const T* texels = level.row(std::max(row, 0));
  if (row >= 0 && s0 >= 0 && s1 < level.width) {
    for (int s = s0; s <= s1; ++s) {
      const float w = weights.next();
      sumWeights += w;
      sum += texels[s] * w;
    }
    return;
  }
  for (int s = s0; s <= s1; ++s) {
    const float w = weights.next();
    sumWeights += w;
    const int column = wrapIndex(s, level.width, settings_.wrap);
    if (row >= 0 && column >= 0) sum += texels[column] * w;
  }
}

template <class T>
T MipMap<T>::ewa(const Level& level, Vec2 st, Vec2 dst0, Vec2 dst1) const {
  const Vec2 center = scaled(st, level.width, level.height) - Vec2(.5f);
  dst0 = scaled(dst0, level.width, level.height);
  dst1 = scaled(dst1, level.width, level.height);

  // The ellipse A s^2 + B s t + C t^2 < 1 around the centre, widened by one texel. Its discriminant
  // 4 A C - B^2 is 4 / F, with F in a form that does not cancel.
  float A = dst0.y * dst0.y + dst1.y * dst1.y + 1;
  float C = dst0.x * dst0.x + dst1.x * dst1.x + 1;
  const float tExtent = std::sqrt(A);
  const float invF = 1 / (sqr(dst0.x * dst1.y - dst0.y * dst1.x) + A + C - 1);
  const float B = -2 * (dst0.x * dst0.y + dst1.x * dst1.y) * invF;
  A *= invF;
  C *= invF;

  T sum{};
  float sumWeights = 0;
  const float invA = 1 / A;
  const int tEnd = floorToInt(center.y + tExtent);
  for (int t = ceilToInt(center.y - tExtent); t <= tEnd; ++t) {
    // The texels of this row inside the ellipse: the roots of the quadratic in s.
    const float dt = static_cast<float>(t) - center.y;
    const float b = B * dt, c = C * dt * dt;
    const float middle = center.x - .5f * b * invA;
    const float half = safeSqrt(A - invF * dt * dt) * invA;
    const int s0 = ceilToInt(middle - half), s1 = floorToInt(middle + half);
    const float ds = static_cast<float>(s0) - center.x;
    const RowWeights weights{(A * ds + b) * ds + c, A * (2 * ds + 1) + b, 2 * A};
    accumulateRow(level, t, s0, s1, weights, sum, sumWeights);
  }
  // The widened ellipse always covers the texel nearest to its centre; only an overflow misses it.
  return sumWeights > 0 ? sum / sumWeights : bilinear(level, st);
}

template class MipMap<float>;
template class MipMap<Rgb>;

}  // namespace brume
