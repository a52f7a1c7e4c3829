// SPDX-License-Identifier: Apache-2.0
#include "core/deferred.h"
#include "core/file_cache.h"
#include "core/material.h"
#include "core/registry.h"
#include "materials/lobes_measured.h"

namespace brume {
namespace {

/// The table of a file, shared by all materials of a scene that name it: exporters write the same
/// material before every shape, and a MERL table is 17 MB. It is read at the first lookup if the
/// file looks right, at once if it does not.
template <class Brdf>
const Deferred<Brdf>* deferOnce(FileCache& files, const std::string& path,
                                const SourceLocation& where) {
  return files
      .get<std::unique_ptr<const Deferred<Brdf>>>(
          path,
          [&] {
            auto brdf = std::make_unique<const Deferred<Brdf>>(
                path, Brdf::bytesOf(path), [path, where] { return Brdf(path, where); });
            if (!Brdf::hasUsualHead(path)) brdf->load();
            DeferredFiles::of(files).add(*brdf);
            return brdf;
          })
      .get();
}

/// A measured isotropic BRDF from a file: the MERL format (see MerlBrdf), or, by the suffix .brdf,
/// a text of irregular samples (see IrregularBrdf). Reflects on both sides.
/// The file is read when a ray first meets the material. Test: measured_test.
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
      irregular_ = deferOnce<IrregularBrdf>(*files_, file.path, where);
    else
      merl_ = deferOnce<MerlBrdf>(*files_, file.path, where);
  }

  bool hasSpecular() const override { return false; }
  bool hasNonSpecular() const override { return true; }
  int maxLobes() const override { return 1; }
  const FloatSlot* bumpMap() const override { return orNull(params_.bumpmap); }

  void addLobes(const SurfaceInteraction&, Bsdf& bsdf) const override {
    if (merl_)
      bsdf.add<MerlLobe>(merl_->get());
    else
      bsdf.add<IrregularLobe>(irregular_->get());
  }

 private:
  Params params_;
  FileCacheOf files_;
  const Deferred<MerlBrdf>* merl_ = nullptr;  // one of the two
  const Deferred<IrregularBrdf>* irregular_ = nullptr;
};

const RegisterPlugin<Material, Measured> kRegistration{
    "measured", Origin::PbrtV2, "measured isotropic BRDF, MERL or irregular samples"};

}  // namespace
}  // namespace brume
