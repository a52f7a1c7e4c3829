// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/film_layers.h"
#include "core/filter.h"
#include "core/io/image.h"
#include "core/params.h"
#include "core/rgb.h"

namespace brume {

/// Filtered sums of one rectangle of samples; private to a thread until it is merged into the Film.
class FilmTile {
 public:
  /// `pixels` are those that get sums; samples may fall outside and reach in.
  FilmTile(const Bounds2i& pixels, const Filter& filter, bool withVariance, bool withLayers);
  /// Adds radiance at a raster position to every pixel whose filter reaches it; and the layers, in
  /// a film that has them.
  void addSample(Vec2 raster, const Rgb& L, const LayerSample* layers = nullptr);
  const Bounds2i& pixels() const { return pixels_; }

  /// Per pixel, in double.
  struct Sums {
    double w = 0;              ///< sum of filter weights
    double wL[3] = {0, 0, 0};  ///< sum of w L
  };
  /// For the variance of the pixel value: sum (w (L - mean))^2 / (sum w)^2.
  struct Moments {
    double w2 = 0;
    double w2L[3] = {0, 0, 0}, w2L2[3] = {0, 0, 0};
    std::uint64_t samples = 0;  ///< that reached the pixel
  };
  /// Sums of w times each channel of the layers, and of w alone over all samples with layers and
  /// over those that met a surface.
  struct LayerSums {
    double w = 0, wHit = 0;
    std::array<double, kLayerChannels> wV{};
  };

 private:
  friend class Film;
  void addToPixel(Vec2i pixel, double w, const Rgb& L);
  void addLayersToPixel(Vec2i pixel, double w);
  template <class Add>
  void forEachPixel(Vec2 raster, Add&& add) const;

  Bounds2i pixels_;
  const Filter& filter_;
  Vec2 radius_;
  bool onePixelPerSample_ = false;  // the filter is the pixel's own square
  std::vector<Sums> sums_;
  std::vector<Moments> moments_;   // empty without variance
  std::vector<LayerSums> layers_;  // empty without layers
  bool hasComponents_ = false;
  // The sample that is being added.
  std::array<float, kLayerChannels> values_{};
  bool hasHit_ = false;
};

/// A relative error divides the square of each difference by value^2 + kDarkShare mean^2, mean over
/// the image, so that dark pixels do not count more than they are seen.
inline constexpr double kDarkShare = 0.01;

/// What the camera's light is gathered on. Sums are kept in double; tiles are merged in the order
/// that the renderer fixes, so the image does not depend on the number of threads.
class Film {
 public:
  static constexpr std::string_view kPluginKind = "Film";
  struct FactoryContext {
    const Filter* filter = nullptr;            ///< owned by the caller, outlives the film
    std::string outputName;                    ///< --outfile; wins over the scene's filename
    std::optional<Vec2i> resolution;           ///< --resolution
    std::optional<std::array<float, 4>> crop;  ///< --crop x0,x1,y0,y1
    bool quick = false;                        ///< --quick
    bool variance = false;                     ///< wanted in the image
    bool needsVariance = false;                ///< by who renders (--error), in the image or not
    bool layers = false;                       ///< --layers
    SourceLocation where;
    Log* log = nullptr;
  };
  struct Settings {
    Vec2i resolution{640, 480};
    Bounds2i crop;  ///< pixels of the image that are rendered
    std::string filename = "pbrt.exr";
    PixelPrecision precision = PixelPrecision::Half;
    bool withVariance = false;
    bool withLayers = false;
  };
  virtual ~Film() = default;
  Film(const Settings& settings, const Filter& filter);

  const Settings& settings() const { return settings_; }
  Vec2i resolution() const { return settings_.resolution; }
  /// Pixels whose samples reach the crop window through the filter.
  Bounds2i sampleBounds() const;
  /// A tile for the samples in `samples`: its pixels reach as far as the filter, within the crop
  /// window.
  FilmTile makeTile(const Bounds2i& samples) const;
  /// Adds a tile's sums. Not thread-safe; call in a fixed order.
  void merge(const FilmTile& tile);
  /// The same for passes whose samples share their randomness (photons). For the variance
  /// kPassesPerSample passes count as one sample of each pixel: the samples of one pass are not
  /// independent, and those of neighbouring passes complement each other where the sampler's do.
  /// A pass is its tiles, then its end.
  FilmTile makeTileOfPass(const Bounds2i& samples) const;
  void mergeIntoPass(const FilmTile& tile);
  void endPass();
  static constexpr std::int64_t kPassesPerSample = 4;
  /// The image so far: R, G, B = max(0, sum w L / sum w), 0 where nothing fell; "variance.R/G/B"
  /// [variance of the pixel value, unclamped; infinite below two samples] and "samples" when asked
  /// for; and the layers (layerChannelNames), unclamped: their means over the samples, the depth's
  /// over those that meet a surface, infinite where none does; the components only when some
  /// integrator told them apart.
  LayeredImage develop() const;
  /// Square root of the mean over pixels and channels of variance / (value^2 + kDarkShare mean^2):
  /// an estimate of the relative error. Needs withVariance.
  double estimatedRelativeError() const;

  /// Bytes per pixel of a film with and without variance, the developed image included.
  static std::size_t bytesPerPixel(bool withVariance, bool withLayers);

 private:
  Settings settings_;
  const Filter& filter_;
  std::vector<FilmTile::Sums> sums_;
  std::vector<FilmTile::Moments> moments_;
  std::vector<FilmTile::Sums> passSums_;  // not yet in moments_; empty without variance
  std::int64_t passes_ = 0;
  std::vector<FilmTile::LayerSums> layers_;
  bool hasComponents_ = false;
  FilmTile makeTile(const Bounds2i& samples, bool withVariance) const;
  double varianceScale() const;
  void developLayers(LayeredImage& image) const;
};

}  // namespace brume
