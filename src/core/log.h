// SPDX-License-Identifier: Apache-2.0
// Warnings and messages. Libraries report through a Log; only main() decides what is printed where.
#pragma once

#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"

namespace brume {

enum class Verbosity { Quiet, Normal, Verbose };

/// Collects and prints diagnostics in the form "file:line:column: warning: text" with the source
/// line and a caret. Thread-safe. Errors are not logged here: they are thrown as SceneError.
class Log {
 public:
  struct Options {
    Verbosity verbosity = Verbosity::Normal;
    bool strict = false;   ///< every warning becomes a SceneError
    bool capture = false;  ///< keep the lines in captured() and print nothing (tests)
  };
  Log() = default;
  explicit Log(const Options& options) : options_(options) {}

  /// Something the user should know; thrown as SceneError when strict. Silent when quiet.
  void warning(const SourceLocation& where, const std::string& text);
  /// Shown only with --verbose.
  void verbose(const std::string& text);
  /// The same, but only the first time this text is given.
  void verboseOnce(const std::string& text);

  int warningCount() const;
  std::vector<std::string> captured() const;
  const Options& options() const { return options_; }

 private:
  void print(const std::string& line);

  Options options_;
  mutable std::mutex mutex_;
  std::vector<std::string> lines_;
  std::vector<std::string> once_;
  int warnings_ = 0;
};

/// "file:line:column: kind: text", then the source line with a caret below, when the line can still
/// be read.
std::string formatDiagnostic(const SourceLocation& where, std::string_view kind,
                             const std::string& text);

}  // namespace brume
