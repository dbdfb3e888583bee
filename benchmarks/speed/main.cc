#include <benchmark/benchmark.h>
#include <kedge/base/environment.h>

int main(int argc, char** argv)
{
  kedge::Environment environment(argc, argv);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv))
    return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
