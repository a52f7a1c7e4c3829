// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <fmt/format.h>

#include "core/film.h"
#include "core/log.h"
#include "core/registry.h"

namespace brume {
namespace {

/// Largest film, and never more than the machine's memory.
constexpr double kMaxBytes = 64e9;

double memoryOfMachine() {
  const double pages = static_cast<double>(sysconf(_SC_PHYS_PAGES));
  const double pageSize = static_cast<double>(sysconf(_SC_PAGESIZE));
  return pages > 0 && pageSize > 0 ? pages * pageSize : kMaxBytes;
}

/// PBRT-v2's film: filtered radiance per pixel, no exposure, no tone curve. A pixel is
///   max(0, sum_i w_i L_i / sum_i w_i)       [W m^-2 sr^-1], per channel
/// with the exact weights of the PixelFilter (PBRT-v2 looks them up in a 16x16 table). The
/// extension of the file name chooses the format. Test: film_test.
class ImageFilm final : public Film {
 public:
  struct Params {
    int xresolution = 640, yresolution = 480;
    std::string filename = "pbrt.exr";
    std::optional<std::array<float, 4>> cropwindow;
    bool display = false;
    PixelPrecision precision = PixelPrecision::Half;
    bool variance = false;
    bool layers = false;

    void visit(ParamVisitor& v) {
      // Beyond 2^20 a float cannot tell positions inside a pixel apart any more.
      constexpr Range<int> kResolution{1, 1 << 20};
      v(xresolution, "xresolution", kResolution, Unit::Pixels, "width of the full image");
      v(yresolution, "yresolution", kResolution, Unit::Pixels, "height of the full image");
      v(filename, "filename",
        "image file (.exr, .png, .pfm, .tga), relative to the working directory");
      v(cropwindow, "cropwindow", kUnitInterval, Unit::None,
        "x0 x1 y0 y1 of the part that is rendered, as fractions of the image from the top left; "
        "default: all of it");
      v(display, "display", "accepted with a warning: brume opens no window");
      v(precision, "precision", {{"half", PixelPrecision::Half}, {"float", PixelPrecision::Float}},
        "of the colours in an .exr file; depths, variances and samples are floats");
      v(variance, "variance", "write the variance of each pixel and its number of samples (.exr)");
      v(layers, "layers",
        "write the parts of the light (volpath), depth, normal, albedo and transmittance (.exr)");
    }
  };

  ImageFilm(const Params& params, const FactoryContext& context)
      : Film(makeSettings(params, context), *context.filter) {}

 private:
  static Settings makeSettings(const Params& params, const FactoryContext& context) {
    Settings settings;
    settings.resolution = resolution(params, context);
    settings.crop =
        cropPixels(settings.resolution, context.crop ? context.crop : params.cropwindow);
    settings.precision = params.precision;
    const bool wantsVariance = params.variance || context.variance;
    settings.withVariance = wantsVariance || context.needsVariance;
    settings.withLayers = params.layers || context.layers;
    checkMemory(settings, context);

    settings.filename = context.outputName.empty() ? params.filename : context.outputName;
    if (!context.outputName.empty() && context.outputName != params.filename)
      context.log->verbose(fmt::format("the image goes to '{}' instead of the scene's '{}'",
                                       context.outputName, params.filename));
    if (!isWritableImageName(settings.filename)) {
      const std::string text = fmt::format(
          "cannot write '{}': choose a name that ends in '.exr', '.png', '.pfm' or '.tga'",
          settings.filename);
      throw context.outputName.empty() ? SceneError(context.where, text) : SceneError(text);
    }
    if ((wantsVariance || settings.withLayers) && !settings.filename.ends_with(".exr"))
      context.log->warning(
          context.where,
          fmt::format("'{}' holds colour only: {} not "
                      "written; choose a name that ends in '.exr'",
                      settings.filename, settings.withLayers ? "layers are" : "the variance is"));
    if (params.display)
      context.log->warning(context.where, "\"display\" has no effect: brume opens no window");
    return settings;
  }

  static Vec2i resolution(const Params& params, const FactoryContext& context) {
    if (context.resolution) {
      constexpr int kMax = 1 << 20;
      const Vec2i r = *context.resolution;
      if (r.x < 1 || r.y < 1 || r.x > kMax || r.y > kMax)
        throw SceneError(
            fmt::format("--resolution {}x{}: each must lie between 1 and {}", r.x, r.y, kMax));
      return r;
    }
    const Vec2i full(params.xresolution, params.yresolution);
    return context.quick ? Vec2i(std::max(1, full.x / 4), std::max(1, full.y / 4)) : full;
  }

  /// PBRT-v2's rounding: the first pixel is ceil(res x0), the end ceil(res x1), at least one pixel.
  static Bounds2i cropPixels(Vec2i resolution, const std::optional<std::array<float, 4>>& window) {
    if (!window) return {{0, 0}, resolution};
    Bounds2i crop;
    for (int axis = 0; axis < 2; ++axis) {
      const auto [a, b] = std::minmax((*window)[2 * axis], (*window)[2 * axis + 1]);
      const float n = static_cast<float>(resolution[axis]);
      const auto pixel = [n](float x) {
        return static_cast<int>(std::ceil(n * (x > 0.f ? std::min(x, 1.f) : 0.f)));
      };
      crop.lo[axis] = std::min(pixel(a), resolution[axis] - 1);
      crop.hi[axis] = std::max(pixel(b), crop.lo[axis] + 1);
    }
    return crop;
  }

  static void checkMemory(const Settings& settings, const FactoryContext& context) {
    const double bytes =
        static_cast<double>(settings.crop.area()) *
        static_cast<double>(bytesPerPixel(settings.withVariance, settings.withLayers));
    const double limit = std::min(kMaxBytes, memoryOfMachine());
    if (bytes > limit)
      throw SceneError(
          context.where,
          fmt::format("an image of {} x {} pixels needs {:.1f} GB of memory, more than {:.1f} GB; "
                      "lower the resolution or render crop windows",
                      settings.crop.width(), settings.crop.height(), bytes * 1e-9, limit * 1e-9));
  }
};

const RegisterPlugin<Film, ImageFilm> kRegistration{"image", Origin::PbrtV2,
                                                    "image file of filtered radiance"};

}  // namespace
}  // namespace brume
