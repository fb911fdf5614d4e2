// Identification in two steps: first what depends only on the inputs, then the outputs. The taxels of an array share
// their inputs, so that the first step is made once for all of them.
#pragma once

#include <memory>
#include <string>

#include "analysis/identify/fit_data.h"

namespace tactbench::analysis {

class Identifier {
 public:
  virtual ~Identifier() = default;
  // From any thread. Throws std::invalid_argument when the inputs or branches are not those it was prepared for, or as
  // identify_* does.
  [[nodiscard]] virtual ModelFit fit(const FitData& data) const = 0;
};

// Throw as identify_* does. Only inputs, branches and the patterns' range of `like` are used.
std::unique_ptr<Identifier> prepare_gpi(const FitData& like, const IdentifyOptions& options);
std::unique_ptr<Identifier> prepare_mpi(const FitData& like, const IdentifyOptions& options);
std::unique_ptr<Identifier> prepare_poly(const FitData& like, const IdentifyOptions& options);
std::unique_ptr<Identifier> prepare_preisach(const FitData& like, const IdentifyOptions& options);
std::unique_ptr<Identifier> prepare_monotone(const FitData& like, const IdentifyOptions& options);

// By name, as identify(): from the `no_loop` of `like`, too.
std::unique_ptr<Identifier> prepare(const std::string& name, const FitData& like, const IdentifyOptions& options = {});

}  // namespace tactbench::analysis
