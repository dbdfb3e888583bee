#include <cstdio>
#include <kedge/base/environment.h>
#include <kedge/simulation/check.h>
#include <kedge/simulation/input.h>

int main(int argc, char** argv)
{
  kedge::Environment environment(argc, argv);
  const kedge::Input input = kedge::read_input(argv[1]);
  const std::string text = kedge::format_check(input, kedge::check_scene(input), argv[1]);
  std::fputs(text.c_str(), stdout);
}
