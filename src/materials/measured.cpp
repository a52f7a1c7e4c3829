// SPDX-License-Identifier: Apache-2.0
#include "core/file_cache.h"
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes_measured.h"

namespace brume {
namespace {

/// The table of a file, shared by all materials of a scene that name it: exporters write the same
/// material before every shape, and a MERL table is 17 MB.
template <class Brdf>
const Brdf* loadOnce(FileCache& files, const std::string& path, const SourceLocation& where) {
  return files
      .get<std::unique_ptr<const Brdf>>(path,
                                        [&] { return std::make_unique<const Brdf>(path, where); })
      .get();
}

/// A measured isotropic BRDF from a file: the MERL format (see MerlBrdf), or, by the suffix .brdf,
/// a text of irregular samples (see IrregularBrdf). Reflects on both sides. Test: measured_test.
class Measured final : public Material {
 public:
  struct Params {
    Filename filename;
    std::optional<FloatSlot> bumpmap;
    void visit(ParamVisitor& v) {
      v(filename, "filename",
        "the measurement: .brdf (text, irregular samples) or the MERL format (binary)");
      declareBumpMap(v, bumpmap);
    }
  };

  Measured(Params params, const FactoryContext& context)
      : params_(std::move(params)), files_(context.files) {
    const Filename& file = params_.filename;
    if (!file.isGiven())
      throw SceneError(context.where, "Material 'measured' needs the parameter 'string filename'");
    const SourceLocation& where = file.where.isKnown() ? file.where : context.where;
    if (file.path.ends_with(".brdf") || file.path.ends_with(".BRDF"))
      irregular_ = loadOnce<IrregularBrdf>(*files_, file.path, where);
    else
      merl_ = loadOnce<MerlBrdf>(*files_, file.path, where);
  }

  bool hasSpecular() const override { return false; }
  bool hasNonSpecular() const override { return true; }
  int maxLobes() const override { return 1; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction&, Bsdf& bsdf) const override {
    if (merl_)
      bsdf.add<MerlLobe>(*merl_);
    else
      bsdf.add<IrregularLobe>(*irregular_);
  }

 private:
  Params params_;
  FileCacheOf files_;
  const MerlBrdf* merl_ = nullptr;  // one of the two
  const IrregularBrdf* irregular_ = nullptr;
};

const RegisterPlugin<Material, Measured> kRegistration{
    "measured", Origin::PbrtV2, "measured isotropic BRDF, MERL or irregular samples"};

}  // namespace
}  // namespace brume
