// State of the simulated specimen between runs: the film's memory, kept in a file; and the object that presses on it.
#pragma once

#include <string>
#include <vector>

#include "bench/config/config.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

class Rig;

// Both do nothing without a file, and on a rig that is not simulated in this process. Throw Error TB-SPECIMEN-STATE.
void load_specimen(Rig& rig, const std::string& file);  // if it exists
void save_specimen(Rig& rig, const std::string& file);

// A rig simulated in this process gets the recipe's object on its stage.
BenchConfig with_object(BenchConfig bench, const std::vector<sequences::Recipe>& recipes);

}  // namespace tactbench::bench
