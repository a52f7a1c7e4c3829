// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/file_cache.h"
#include "core/io/image.h"
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

template <class T>
MipMap<T> makePyramid(const ImageMapParams& params, FileCache& files) {
  const RgbImage& image = files.get<RgbImage>(params.filename.path, [&] {
    return readTextureImage(params.filename.path, params.filename.where);
  });
  std::vector<T> texels(image.pixels.size());
  for (std::size_t i = 0; i < texels.size(); ++i) convert(image.pixels[i], params, texels[i]);
  try {
    return {image.width, image.height, std::move(texels), params.filter};
  } catch (const SceneError& e) {
    throw SceneError(params.filename.where,
                     fmt::format("cannot use image '{}': {}", params.filename.path, e.what()));
  }
}

/// The pyramid of a file with these settings, made once for all textures that share them.
template <class T>
const MipMap<T>& pyramidOf(const ImageMapParams& p, FileCache& files, const SourceLocation& where) {
  if (!p.filename.isGiven()) throw SceneError(where, "imagemap needs \"string filename\"");
  const std::string key =
      fmt::format("{} {} {} {} {} {}", p.scale, p.gamma, static_cast<int>(p.filter.wrap),
                  p.filter.trilinear, p.filter.maxAnisotropy, p.filename.path);
  return files.get<MipMap<T>>(key, [&] { return makePyramid<T>(p, files); });
}

/// An image, filtered over the footprint; t = 0 is the top row of EXR files, the bottom row of all
/// others (readTextureImage). A float texture is the luminance. 8-bit values are used as they
/// stand: "gamma" 2.2 makes sRGB images about linear. Test: textures_test.
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
    return pyramid_.lookup(q.st, q.dstdx, q.dstdy);
  }

 private:
  Mapping2D mapping_;
  FileCacheOf files_;
  const MipMap<T>& pyramid_;
};

constexpr const char* kSummary = "filtered image from a file";
const RegisterPlugin<Texture<float>, ImageMapTexture<float>> kFloat{"imagemap", Origin::PbrtV2,
                                                                    kSummary};
const RegisterPlugin<Texture<Rgb>, ImageMapTexture<Rgb>> kRgb{"imagemap", Origin::PbrtV2, kSummary};

}  // namespace
}  // namespace brume
