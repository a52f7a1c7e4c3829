// SPDX-License-Identifier: Apache-2.0
// Runs the built brume as a user does, for tests of the command line.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace brume::test {

/// A folder that exists as long as this object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Writes a file into the folder and returns its full name.
  std::string write(const std::string& name, const std::string& text) const;
  /// Names of what lies in it, sorted.
  std::vector<std::string> files() const;

 private:
  std::filesystem::path path_;
};

struct ProgramResult {
  int exitCode = -1;  ///< -signal when it was killed
  std::string out, err;
  double seconds = 0;
  double cpuSeconds = 0;
  std::size_t peakBytes = 0;  ///< most memory it held at once
};

struct ProgramInput {
  std::vector<std::string> arguments = {};
  std::filesystem::path workingFolder = {};  ///< empty: the present one
  std::string standardInput = {};
  /// A signal that is sent once standard error holds `waitFor`.
  std::optional<int> signal = {};
  std::string waitFor = {};
  bool signalsChild = false;  ///< the signal goes to the process that it has started
  /// Limit for the size of any file it writes [bytes]: a full disk.
  std::optional<std::size_t> fileSizeLimit = {};
};

/// Runs build/brume and waits for its end, a minute at most.
ProgramResult runBrume(const ProgramInput& input);

std::string readFile(const std::filesystem::path& path);

}  // namespace brume::test
