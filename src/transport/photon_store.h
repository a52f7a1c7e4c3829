// SPDX-License-Identifier: Apache-2.0
// Photons that are kept in files from one render to the next: parameters and behaviour that all
// photon methods share.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/integrator.h"
#include "transport/photon_tracer.h"

namespace brume {

/// Part of the parameters of a photon method: its visit() calls this one.
struct PhotonFileParams {
  std::string loadphotons, savephotons;

  void visit(ParamVisitor& v) {
    v(loadphotons, "loadphotons",
      "photon file to use instead of tracing; relative to the working directory");
    v(savephotons, "savephotons",
      "photon file to write, for loadphotons and 'brume photons'; relative to the working "
      "directory");
  }
  std::vector<std::string> outputs() const {
    return savephotons.empty() ? std::vector<std::string>{} : std::vector{savephotons};
  }
};

/// What a method cannot do without, and what it uses when there is any.
struct PhotonNeeds {
  PhotonClasses required{}, optional{};
};

/// The photons in the file that loadphotons names, moved to the scene's origin and without classes
/// that are not needed; or else those of `trace`. Then writes them to the file of savephotons,
/// whose place is tested first. Throws SceneError when a file cannot be used: when it lacks a class
/// that is required, too.
PhotonSet loadOrTracePhotons(const PhotonFileParams& files, const PhotonNeeds& needs,
                             const Scene& scene, const PrepareContext& context,
                             const std::function<PhotonSet()>& trace);
/// Reads the file that loadphotons names, if it names one that is not still to be written, and
/// throws and warns as loadOrTracePhotons would.
void checkPhotonFile(const PhotonFileParams& files, const PhotonNeeds& needs, const Scene& scene,
                     const std::set<std::string>& toBeWritten, Log& log);

}  // namespace brume
