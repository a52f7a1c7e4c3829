// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <mutex>
#include <new>
#include <optional>

#include "core/deferred.h"
#include "core/file_cache.h"
#include "core/io/image.h"
#include "core/io/image_head.h"
#include "core/mipmap.h"
#include "core/registry.h"
#include "textures/mapping.h"

namespace brume {
namespace {

struct ImageMapParams {
  Mapping2D::Params mapping;
  Filename filename;
  MipMapSettings filter;
  float scale = 1, gamma = 1;

  void visit(ParamVisitor& v) {
    mapping.visit(v);
    v(filename, "filename", "image: .exr .png .pfm .tga .jpg .hdr");
    v(filter.wrap, "wrap",
      {{"repeat", WrapMode::Repeat}, {"black", WrapMode::Black}, {"clamp", WrapMode::Clamp}},
      "what lies outside [0,1]^2");
    v(filter.maxAnisotropy, "maxanisotropy", Range<float>{1.f, 1024.f}, Unit::None,
      "longest ratio of the axes of the filter");
    v(filter.trilinear, "trilinear", "isotropic filter instead of the elliptical one");
    v(scale, "scale", kAnyFloat, Unit::None, "values are (scale v)^gamma");
    v(gamma, "gamma", kPositive, Unit::None, "values are (scale v)^gamma");
  }
};

/// v^gamma; with a gamma other than 1 negative values, which have no power, count as 0.
float power(float v, float gamma) { return gamma == 1 ? v : std::pow(std::max(v, 0.f), gamma); }

void convert(const Rgb& from, const ImageMapParams& p, Rgb& to) {
  for (int c = 0; c < 3; ++c) to[c] = power(p.scale * from[c], p.gamma);
}
void convert(const Rgb& from, const ImageMapParams& p, float& to) {
  to = power(p.scale * from.luminance(), p.gamma);
}

/// The pixels of a file, which live from the making of the first pyramid to that of the last.
class TexturePixels {
 public:
  explicit TexturePixels(const Filename& file) : file_(file) {}

  /// Announces a call of lend.
  void expectUser() { ++users_; }
  /// use(the image); the file is read when it is not at hand.
  template <class Use>
  auto lend(const Use& use) {
    const std::lock_guard lock(mutex_);
    if (!image_) image_ = readTextureImage(file_.path, file_.where);
    auto result = use(*image_);
    if (--users_ == 0) image_.reset();
    return result;
  }

 private:
  Filename file_;
  std::mutex mutex_;
  int users_ = 0;
  std::optional<RgbImage> image_;
};

template <class T>
MipMap<T> makePyramid(const RgbImage& image, const ImageMapParams& params) {
  const auto fail = [&](const char* reason) {
    return SceneError(params.filename.where,
                      fmt::format("cannot use image '{}': {}", params.filename.path, reason));
  };
  try {
    std::vector<T> texels(image.pixels.size());
    for (std::size_t i = 0; i < texels.size(); ++i) convert(image.pixels[i], params, texels[i]);
    return {image.width, image.height, std::move(texels), params.filter};
  } catch (const SceneError& e) {
    throw fail(e.what());
  } catch (const std::bad_alloc&) {
    throw fail("out of memory");
  }
}

template <class T>
using DeferredPyramid = Deferred<MipMap<T>>;

/// A pyramid that is made at the first lookup, if the file looks whole and its pyramid fits into
/// memory; in every doubt at once, so that what is wrong shows before anything is rendered.
template <class T>
std::unique_ptr<DeferredPyramid<T>> deferPyramid(const ImageMapParams& p, FileCache& files) {
  const std::string& path = p.filename.path;
  const auto& size = files.get<std::optional<Vec2i>>(path, [&] { return sizeOfWholeImage(path); });
  if (size && MipMap<T>::fits(*size)) {
    TexturePixels& pixels = *files.get<std::unique_ptr<TexturePixels>>(
        path, [&] { return std::make_unique<TexturePixels>(p.filename); });
    pixels.expectUser();
    return std::make_unique<DeferredPyramid<T>>(path, MipMap<T>::bytes(*size), [&pixels, p] {
      return pixels.lend([&](const RgbImage& image) { return makePyramid<T>(image, p); });
    });
  }
  const RgbImage& image =
      files.get<RgbImage>(path, [&] { return readTextureImage(path, p.filename.where); });
  auto pyramid =
      std::make_unique<DeferredPyramid<T>>(path, MipMap<T>::bytes({image.width, image.height}),
                                           [&image, p] { return makePyramid<T>(image, p); });
  pyramid->load();
  return pyramid;
}

/// The pyramid of a file with these settings, one for all textures that share them.
template <class T>
const DeferredPyramid<T>& pyramidOf(const ImageMapParams& p, FileCache& files,
                                    const SourceLocation& where) {
  if (!p.filename.isGiven()) throw SceneError(where, "imagemap needs \"string filename\"");
  const std::string key =
      fmt::format("{} {} {} {} {} {}", p.scale, p.gamma, static_cast<int>(p.filter.wrap),
                  p.filter.trilinear, p.filter.maxAnisotropy, p.filename.path);
  return *files.get<std::unique_ptr<DeferredPyramid<T>>>(key, [&] {
    auto pyramid = deferPyramid<T>(p, files);
    DeferredFiles::of(files).add(*pyramid);
    return pyramid;
  });
}

/// An image, filtered over the footprint; t = 0 is the top row of EXR files, the bottom row of all
/// others (readTextureImage). A float texture is the luminance. 8-bit values are used as they
/// stand: "gamma" 2.2 makes sRGB images about linear. The file is read when the texture is first
/// looked up. Test: textures_test.
template <class T>
class ImageMapTexture final : public Texture<T> {
 public:
  using Params = ImageMapParams;

  ImageMapTexture(Params params, const TextureFactoryContext& context)
      : mapping_(params.mapping, context),
        files_(context.files),
        pyramid_(pyramidOf<T>(params, *files_, context.where)) {}

  T evaluate(const TextureContext& at) const override {
    const TexturePoint2 q = mapping_(at);
    return pyramid_.get().lookup(q.st, q.dstdx, q.dstdy);
  }

 private:
  Mapping2D mapping_;
  FileCacheOf files_;
  const DeferredPyramid<T>& pyramid_;
};

constexpr const char* kSummary = "filtered image from a file";
const RegisterPlugin<Texture<float>, ImageMapTexture<float>> kFloat{"imagemap", Origin::PbrtV2,
                                                                    kSummary};
const RegisterPlugin<Texture<Rgb>, ImageMapTexture<Rgb>> kRgb{"imagemap", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
