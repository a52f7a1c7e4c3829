// SPDX-License-Identifier: Apache-2.0
#include "core/film.h"

#include <array>
#include <span>

#include "core/error.h"

namespace brume {

namespace {

/// Most pixels that a filter reaches along one axis.
constexpr int kMaxReach = 2 * static_cast<int>(kMaxFilterRadius) + 2;

/// Pixels [first, last] along one axis that a sample reaches. A pixel takes samples of the
/// half-open interval [centre - radius, centre + radius), so that filters of half a pixel give each
/// sample to exactly one. In double: exact for every float position.
struct Reach {
  int first = 0, last = -1;
};
Reach pixelsReached(double raster, double radius, int lo, int hi) {
  const double first = std::floor(raster - 0.5 - radius) + 1;
  const double last = std::floor(raster - 0.5 + radius);
  // Also false for NaN; the comparisons keep the conversion to int in range.
  if (!(first < hi && last >= lo)) return {};
  return {static_cast<int>(std::max<double>(first, lo)),
          static_cast<int>(std::min<double>(last, hi - 1))};
}

std::size_t pixelIndex(const Bounds2i& bounds, Vec2i pixel) {
  return static_cast<std::size_t>(pixel.y - bounds.lo.y) *
             static_cast<std::size_t>(bounds.width()) +
         static_cast<std::size_t>(pixel.x - bounds.lo.x);
}

struct PixelValue {
  double L[3] = {0, 0, 0};
  double variance[3] = {0, 0, 0};
};

/// The nearest float, but the largest one for what is larger and finite: infinite stays infinite.
float toFiniteFloat(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  return static_cast<float>(std::isfinite(value) ? std::min(value, kLargest) : value);
}

/// Mean of the samples; its variance as that of a weighted mean of independent samples, with
/// Bessel's factor n/(n-1). Unclamped.
PixelValue pixelValue(const FilmTile::Sums& sums, const FilmTile::Moments* moments) {
  PixelValue value;
  for (int c = 0; c < 3; ++c) value.L[c] = sums.w != 0 ? sums.wL[c] / sums.w : 0;
  if (!moments) return value;
  const double n = static_cast<double>(moments->samples);
  for (int c = 0; c < 3; ++c) {
    const double m = value.L[c];
    const double squares = moments->w2L2[c] - 2 * m * moments->w2L[c] + m * m * moments->w2;
    value.variance[c] = n > 1 && sums.w != 0
                            ? std::max(0.0, squares) / (sums.w * sums.w) * (n / (n - 1))
                            : std::numeric_limits<double>::infinity();
  }
  return value;
}

}  // namespace

FilmTile::FilmTile(const Bounds2i& pixels, const Filter& filter, bool withVariance, bool withLayers)
    : pixels_(pixels),
      filter_(filter),
      radius_(filter.radius()),
      onePixelPerSample_(filter.isConstant() && radius_ == Vec2(0.5f)),
      sums_(static_cast<std::size_t>(pixels.area())),
      moments_(withVariance ? sums_.size() : 0),
      layers_(withLayers ? sums_.size() : 0) {
  BRUME_CHECK(radius_.x <= kMaxFilterRadius && radius_.y <= kMaxFilterRadius);
}

void FilmTile::addToPixel(Vec2i pixel, double w, const Rgb& L) {
  const std::size_t i = pixelIndex(pixels_, pixel);
  Sums& sums = sums_[i];
  sums.w += w;
  for (int c = 0; c < 3; ++c) sums.wL[c] += w * L[c];
  if (moments_.empty()) return;
  Moments& moments = moments_[i];
  const double w2 = w * w;
  moments.w2 += w2;
  for (int c = 0; c < 3; ++c) {
    const double l = L[c];
    moments.w2L[c] += w2 * l;
    moments.w2L2[c] += w2 * l * l;
  }
  ++moments.samples;
}

void FilmTile::addLayersToPixel(Vec2i pixel, double w) {
  LayerSums& sums = layers_[pixelIndex(pixels_, pixel)];
  sums.w += w;
  if (hasHit_) sums.wHit += w;
  for (std::size_t i = 0; i < kLayerChannels; ++i) sums.wV[i] += w * double{values_[i]};
}

template <class Add>
void FilmTile::forEachPixel(Vec2 raster, Add&& add) const {
  const Reach x = pixelsReached(raster.x, radius_.x, pixels_.lo.x, pixels_.hi.x);
  const Reach y = pixelsReached(raster.y, radius_.y, pixels_.lo.y, pixels_.hi.y);
  if (onePixelPerSample_) {
    if (x.first <= x.last && y.first <= y.last) add(Vec2i(x.first, y.first), 1.0);
    return;
  }
  // The filter is separable: its factors are evaluated once per column and row.
  std::array<double, kMaxReach> wx;
  for (int i = x.first; i <= x.last; ++i)
    wx[static_cast<std::size_t>(i - x.first)] =
        filter_.weightX(static_cast<float>(i + 0.5 - raster.x));
  for (int j = y.first; j <= y.last; ++j) {
    const double wy = filter_.weightY(static_cast<float>(j + 0.5 - raster.y));
    for (int i = x.first; i <= x.last; ++i) {
      const double w = wx[static_cast<std::size_t>(i - x.first)] * wy;
      if (w != 0) add(Vec2i(i, j), w);
    }
  }
}

void FilmTile::addSample(Vec2 raster, const Rgb& L, const LayerSample* layers) {
  if (!layers || layers_.empty()) {
    forEachPixel(raster, [&](Vec2i pixel, double w) { addToPixel(pixel, w, L); });
    return;
  }
  values_ = layerValues(*layers);
  hasHit_ = layers->hasHit;
  hasComponents_ = hasComponents_ || layers->components.has_value();
  forEachPixel(raster, [&](Vec2i pixel, double w) {
    addToPixel(pixel, w, L);
    addLayersToPixel(pixel, w);
  });
}

Film::Film(const Settings& settings, const Filter& filter)
    : settings_(settings),
      filter_(filter),
      sums_(static_cast<std::size_t>(settings.crop.area())),
      moments_(settings.withVariance ? sums_.size() : 0),
      layers_(settings.withLayers ? sums_.size() : 0) {
  BRUME_CHECK(settings.crop.area() > 0);
}

std::size_t Film::bytesPerPixel(bool withVariance, bool withLayers) {
  constexpr std::size_t kColour = sizeof(FilmTile::Sums) + 3 * sizeof(float);
  constexpr std::size_t kVariance =
      sizeof(FilmTile::Moments) + sizeof(FilmTile::Sums) + 4 * sizeof(float);
  constexpr std::size_t kLayers = sizeof(FilmTile::LayerSums) + kLayerChannels * sizeof(float);
  return kColour + (withVariance ? kVariance : 0) + (withLayers ? kLayers : 0);
}

Bounds2i Film::sampleBounds() const {
  const Vec2 r = filter_.radius();
  const Bounds2i& crop = settings_.crop;
  const auto down = [](int start, float w) {
    return static_cast<int>(std::floor(start + 0.5 - static_cast<double>(w)));
  };
  const auto up = [](int end, float w) {
    return static_cast<int>(std::ceil(end - 0.5 + static_cast<double>(w)));
  };
  return {{down(crop.lo.x, r.x), down(crop.lo.y, r.y)}, {up(crop.hi.x, r.x), up(crop.hi.y, r.y)}};
}

FilmTile Film::makeTile(const Bounds2i& samples) const {
  return makeTile(samples, settings_.withVariance);
}

FilmTile Film::makeTileOfPass(const Bounds2i& samples) const { return makeTile(samples, false); }

FilmTile Film::makeTile(const Bounds2i& samples, bool withVariance) const {
  // Samples lie in [lo, hi); pixel x takes those within its radius of x + 0.5.
  const Vec2 r = filter_.radius();
  const auto first = [](int lo, float w) {
    return static_cast<int>(std::floor(lo - 0.5 - static_cast<double>(w))) + 1;
  };
  const auto end = [](int hi, float w) {
    return static_cast<int>(std::ceil(hi - 0.5 + static_cast<double>(w)));
  };
  const Bounds2i& crop = settings_.crop;
  Bounds2i pixels{
      {std::max(first(samples.lo.x, r.x), crop.lo.x),
       std::max(first(samples.lo.y, r.y), crop.lo.y)},
      {std::min(end(samples.hi.x, r.x), crop.hi.x), std::min(end(samples.hi.y, r.y), crop.hi.y)}};
  return {pixels, filter_, withVariance, settings_.withLayers};
}

namespace {

void addSums(std::span<const FilmTile::Sums> from, const Bounds2i& part,
             std::span<FilmTile::Sums> to, const Bounds2i& whole) {
  for (int y = part.lo.y; y < part.hi.y; ++y)
    for (int x = part.lo.x; x < part.hi.x; ++x) {
      const FilmTile::Sums& f = from[pixelIndex(part, {x, y})];
      FilmTile::Sums& t = to[pixelIndex(whole, {x, y})];
      t.w += f.w;
      for (int c = 0; c < 3; ++c) t.wL[c] += f.wL[c];
    }
}

}  // namespace

void Film::merge(const FilmTile& tile) {
  const Bounds2i& b = tile.pixels_;
  addSums(tile.sums_, b, sums_, settings_.crop);
  hasComponents_ = hasComponents_ || tile.hasComponents_;
  for (int y = b.lo.y; y < b.hi.y; ++y)
    for (int x = b.lo.x; x < b.hi.x; ++x) {
      const std::size_t from = pixelIndex(b, {x, y}), to = pixelIndex(settings_.crop, {x, y});
      if (!layers_.empty()) {
        const FilmTile::LayerSums& l = tile.layers_[from];
        layers_[to].w += l.w;
        layers_[to].wHit += l.wHit;
        for (std::size_t c = 0; c < kLayerChannels; ++c) layers_[to].wV[c] += l.wV[c];
      }
      if (tile.moments_.empty()) continue;
      const FilmTile::Moments& m = tile.moments_[from];
      moments_[to].w2 += m.w2;
      for (int c = 0; c < 3; ++c) {
        moments_[to].w2L[c] += m.w2L[c];
        moments_[to].w2L2[c] += m.w2L2[c];
      }
      moments_[to].samples += m.samples;
    }
}

void Film::mergeIntoPass(const FilmTile& tile) {
  merge(tile);
  if (moments_.empty()) return;
  passSums_.resize(sums_.size());
  addSums(tile.sums_, tile.pixels_, passSums_, settings_.crop);
}

void Film::endPass() {
  if (++passes_ % kPassesPerSample != 0) return;
  for (std::size_t i = 0; i < passSums_.size(); ++i) {
    FilmTile::Sums& pass = passSums_[i];
    if (pass.w == 0) continue;
    FilmTile::Moments& moments = moments_[i];
    moments.w2 += pass.w * pass.w;
    for (int c = 0; c < 3; ++c) {
      moments.w2L[c] += pass.w * pass.wL[c];
      moments.w2L2[c] += pass.wL[c] * pass.wL[c];
    }
    ++moments.samples;
    pass = {};
  }
}

/// The variance of all passes over that of those in moments_, as if their mean were that of all.
double Film::varianceScale() const {
  const std::int64_t known = passes_ / kPassesPerSample * kPassesPerSample;
  return known == 0 ? 1 : static_cast<double>(passes_) / static_cast<double>(known);
}

LayeredImage Film::develop() const {
  LayeredImage image;
  image.displaySize = settings_.resolution;
  image.dataWindow = settings_.crop;
  static constexpr const char* kColour[3] = {"R", "G", "B"};
  static constexpr const char* kVariance[3] = {"variance.R", "variance.G", "variance.B"};
  std::vector<float>*colour[3], *variance[3] = {}, *samples = nullptr;
  const auto addChannel = [&](const char* name) {
    std::vector<float>& channel = image.channels[name];
    channel.resize(sums_.size());
    return &channel;
  };
  for (int c = 0; c < 3; ++c) colour[c] = addChannel(kColour[c]);
  if (!moments_.empty()) {
    for (int c = 0; c < 3; ++c) variance[c] = addChannel(kVariance[c]);
    samples = addChannel("samples");
  }
  const double scale = varianceScale();
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const FilmTile::Moments* moments = samples ? &moments_[i] : nullptr;
    const PixelValue value = pixelValue(sums_[i], moments);
    for (int c = 0; c < 3; ++c) (*colour[c])[i] = static_cast<float>(std::max(0.0, value.L[c]));
    if (!samples) continue;
    for (int c = 0; c < 3; ++c) (*variance[c])[i] = toFiniteFloat(scale * value.variance[c]);
    (*samples)[i] = static_cast<float>(moments->samples);
  }
  if (!layers_.empty()) developLayers(image);
  return image;
}

void Film::developLayers(LayeredImage& image) const {
  const auto& names = layerChannelNames();
  for (std::size_t c = hasComponents_ ? 0 : kComponentChannels; c < kLayerChannels; ++c) {
    std::vector<float>& channel = image.channels[names[c]];
    channel.resize(layers_.size());
    const bool isDepth = c == kDepthChannel;
    for (std::size_t i = 0; i < layers_.size(); ++i) {
      const double w = isDepth ? layers_[i].wHit : layers_[i].w;
      const double nothing = isDepth ? std::numeric_limits<double>::infinity() : 0;
      channel[i] = static_cast<float>(w != 0 ? layers_[i].wV[c] / w : nothing);
    }
  }
}

double Film::estimatedRelativeError() const {
  BRUME_CHECK(settings_.withVariance);
  const double count = 3.0 * static_cast<double>(sums_.size());
  double mean = 0;
  for (const FilmTile::Sums& sums : sums_)
    for (double L : pixelValue(sums, nullptr).L) mean += std::max(0.0, L) / count;
  double error = 0;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const PixelValue value = pixelValue(sums_[i], &moments_[i]);
    for (int c = 0; c < 3; ++c)
      if (value.variance[c] > 0)  // a black image has no error
        error += value.variance[c] / (sqr(value.L[c]) + kDarkShare * sqr(mean)) / count;
  }
  return std::sqrt(error * varianceScale());
}

}  // namespace brume
