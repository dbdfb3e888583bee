// The command "kedge geometry": makes STL files of bodies from a few dimensions.
#pragma once

namespace CLI
{
class App;
}

namespace kedge
{
/// Adds the subcommand `geometry` with plate, frustum, cone, sphere, box and ac14. Parsing runs the chosen body: it
/// writes the STL file and prints volume, area, centroid and inertia. Parsing may throw InputError and FileError.
void add_geometry_command(CLI::App& app);
} // namespace kedge
