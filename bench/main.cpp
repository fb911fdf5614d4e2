#include "bench/cli/session.h"

int main(int argc, char** argv) { return tactbench::bench::run_command_line(argc, argv); }
