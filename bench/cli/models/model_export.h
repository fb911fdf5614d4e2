// model export: a model as its JSON document, or as a folder for a microcontroller.
#pragma once

#include "bench/cli/session.h"

namespace tactbench::bench {

void add_model_export(CLI::App& model, Session& session);

}  // namespace tactbench::bench
