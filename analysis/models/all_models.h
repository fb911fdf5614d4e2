// The kinds of models, one row each, in the order that people see. All that one takes is declared by its class
// (model.h): equation, inverse and members in the files of its name here, identification in analysis/identify.
#pragma once

#include "analysis/models/elam.h"
#include "analysis/models/gpi.h"
#include "analysis/models/monotone.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"

namespace tactbench::analysis {

template <class... Models>
struct ModelList {};

using AllModels = ModelList<ElamHysteresis, GpiModel, MpiModel, PolyModel, PreisachModel, MonotoneModel>;

}  // namespace tactbench::analysis
