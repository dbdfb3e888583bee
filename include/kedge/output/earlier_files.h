// What an earlier run has left in the folders of a run.
#pragma once

#include <string>

namespace kedge
{
/// Removes a file of an earlier run, if it is there. Throws FileError. Of this process alone.
void remove_earlier_file(const std::string& path);

/// Removes the files of moments (VTK, tables of material points) after `step` and takes them off the lists of moments;
/// step 0: everything that a run writes there, the table of the bodies too. Files with other names stay. Throws
/// FileError. Of this process alone.
void remove_moments_after(unsigned int step, const std::string& vtk_folder, const std::string& csv_folder);
} // namespace kedge
