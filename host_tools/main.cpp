#include "host_tools/cli/command_line.hpp"

int main(int argc, char** argv) {
  return inbetween::run_command_line(argc, argv);
}
