// Valid inputs of each loader, small, made by the writers of the readers' own tests and from the bundled scenarios.
#pragma once

#include <string>
#include <vector>

namespace lacuna::test {

std::vector<std::string> seeds_of_scenario();
std::vector<std::string> seeds_of_urdf();
std::vector<std::string> seeds_of_mjcf();
std::vector<std::string> seeds_of_csv();
std::vector<std::string> seeds_of_mat();
std::vector<std::string> seeds_of_mat73();
std::vector<std::string> seeds_of_db3();
std::vector<std::string> seeds_of_mcap();
std::vector<std::string> seeds_of_bag_metadata();
std::vector<std::string> seeds_of_message();
std::vector<std::string> seeds_of_mesh();
std::vector<std::string> seeds_of_draft();

/// Types of messages; a seed begins with the index of its type.
const std::vector<std::string>& message_types();

}  // namespace lacuna::test
