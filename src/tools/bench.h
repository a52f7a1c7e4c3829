// SPDX-License-Identifier: Apache-2.0
// `brume bench FILE.json`: renders scenes by several methods and shows their error against time.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "core/log.h"

namespace brume {

struct BenchOptions {
  std::string file;    ///< what is measured; see readBenchConfig
  std::string output;  ///< folder for images, results.json and index.html; empty: FILE-results
};

enum class BenchOutcome {
  Done,
  SomeFailed,  ///< references or renders
  SomeFaulty,  ///< of them, some by faults of brume
  Interrupted
};

/// Renders what is not rendered yet (BenchRunner), compares everything with the references and
/// writes results.json and index.html. Interrupted, it keeps what is finished and writes no page.
/// `say` gets a line for each render and for how it ended. Throws SceneError.
BenchOutcome bench(const BenchOptions& options, const std::atomic<bool>& stop,
                   const std::function<void(const std::string&)>& say);

}  // namespace brume
