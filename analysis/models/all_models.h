// The list of model kinds, in the order that people see. To add one: a class with what model.h requires,
// its equation, inverse and members in files of its name in this folder, its identification in analysis/identify.
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
