// The command "kedge geometry": bodies for STL files from a few dimensions.
#pragma once

namespace CLI
{
class App;
}

namespace kedge
{
/// Adds the subcommand `geometry` with plate, frustum, cone, sphere, box and ac14. Parsing runs the chosen one: it
/// writes the STL file and prints volume, area, centroid and inertia. Throws InputError and FileError out of the parse.
void add_geometry_command(CLI::App& app);
} // namespace kedge
