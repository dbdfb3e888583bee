#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/output/history.h>
#include <kedge/output/text_file.h>
#include <sstream>
#include <unistd.h>

namespace kedge
{
namespace
{
/// Gives each rank the rows of a range of numbers. Collective.
ParticleTable deal_out_by_number(const ParticleTable& mine, const std::size_t n_columns, const MPI_Comm communicator)
{
  const int n_ranks = size_of(communicator);
  const long long largest = mine.ids.empty() ? 0 : *std::max_element(mine.ids.begin(), mine.ids.end());
  const auto range = static_cast<long long>(max_over_ranks(double(largest), communicator)) / n_ranks + 1;
  std::vector<std::vector<long long>> ids(n_ranks);
  std::vector<std::vector<double>> values(n_ranks);
  for (std::size_t row = 0; row < mine.ids.size(); ++row)
  {
    const auto to = std::min<long long>(mine.ids[row] / range, n_ranks - 1);
    ids[to].push_back(mine.ids[row]);
    const double* const first = mine.values.data() + row * n_columns;
    values[to].insert(values[to].end(), first, first + n_columns);
  }
  ParticleTable result;
  for (const auto& part : exchange_between_ranks(ids, communicator))
    result.ids.insert(result.ids.end(), part.begin(), part.end());
  for (const auto& part : exchange_between_ranks(values, communicator))
    result.values.insert(result.values.end(), part.begin(), part.end());
  return result;
}

/// In the order of the particles' numbers.
std::string rows_of(const ParticleTable& table, const std::size_t n_columns)
{
  std::vector<std::size_t> order(table.ids.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return table.ids[a] < table.ids[b]; });
  fmt::memory_buffer text;
  for (const std::size_t row : order)
    for (std::size_t column = 0; column < n_columns; ++column)
    {
      // "{}" gives the fewest digits that read back as the same number
      fmt::format_to(fmt::appender(text), "{}", table.values[row * n_columns + column]);
      text.push_back(column + 1 < n_columns ? ',' : '\n');
    }
  return fmt::to_string(text);
}
} // namespace

std::vector<std::string> history_columns(const RigidSystems& bodies, const std::vector<BodyField>& fields)
{
  std::vector<std::string> columns{"time"};
  const auto add = [&](const std::string& name, const unsigned int n_components)
  {
    for (const std::string& column : column_names(name, n_components))
      columns.push_back(column);
  };
  for (std::size_t i = 0; i < bodies.points.size(); ++i)
    for (const BodyField& field : fields)
      add(fmt::format("body{}_{}", i + 1, field.name), field.n_components);
  for (std::size_t i = 0; i < bodies.tracked.size(); ++i)
    add(fmt::format("track{}", i + 1), 3);
  for (std::size_t i = 0; i < bodies.joints.size(); ++i)
    for (const char* const name : {"force", "couple"})
      add(fmt::format("joint{}_{}", i + 1, name), 3);
  columns.insert(columns.end(), {"stage", "step"});
  return columns;
}

ParticleTable tabulate(const std::vector<ParticleView>& particles, const std::vector<ParticleField>& fields)
{
  ParticleTable table;
  table.ids.reserve(particles.size());
  table.values.resize(particles.size() * count_components(fields));
  double* value = table.values.data();
  for (const ParticleView& particle : particles)
  {
    table.ids.push_back(particle.id);
    for (const ParticleField& field : fields)
    {
      field.evaluate(particle, value);
      value += field.n_components;
    }
  }
  return table;
}

void write_particle_csv(const ParticleTable& mine, const std::vector<ParticleField>& fields, const double time,
                        const std::string& path, const MPI_Comm communicator)
{
  const std::size_t n_columns = count_components(fields);
  const std::string rows = rows_of(deal_out_by_number(mine, n_columns, communicator), n_columns);
  std::string columns;
  for (const ParticleField& field : fields)
    columns += fmt::format(",{}", fmt::join(column_names(field.name, field.n_components), ","));
  const std::string draft = draft_of(path);
  const bool is_root = rank_of(communicator) == 0;
  const auto write_rows = [&]
  {
    if (is_root)
      write_text_file(draft, fmt::format("time,{}\n{}\n{}", time, columns.substr(columns.empty() ? 0 : 1), rows));
    else if (!rows.empty())
      append_text(draft, rows);
  };
  try
  {
    for (int turn = 0; turn < size_of(communicator); ++turn)
      agree(communicator,
            [&]
            {
              if (rank_of(communicator) == turn)
                write_rows();
            });
    agree(communicator,
          [&]
          {
            if (is_root)
              give_name(path);
          });
  }
  catch (const FileError&)
  {
    if (is_root)
      std::remove(draft.c_str());
    throw;
  }
}

BodyHistory::BodyHistory(std::string path_, std::vector<BodyField> fields_, const std::size_t most_bytes_)
    : path(std::move(path_)), fields(std::move(fields_)), most_bytes(most_bytes_)
{
}

void BodyHistory::resume_after(unsigned int step)
{
  if (!std::filesystem::exists(path))
    return;
  const std::string text = read_text_file(path);
  std::istringstream lines(text);
  std::string line, kept;
  if (!std::getline(lines, line) || lines.eof())
    return; // not even the names of its columns are there: begun anew
  kept_names = kept = line + "\n";
  while (std::getline(lines, line))
  {
    const std::string last = line.substr(line.rfind(',') + 1);
    const bool is_step = !last.empty() && last.size() < 10 &&
                         std::all_of(last.begin(), last.end(), [](char c) { return std::isdigit(c); });
    // A row without a line end was cut off when the run stopped.
    if (!lines.eof() && is_step && std::stoul(last) <= step)
      kept += line + "\n";
  }
  is_begun = kept.size() > kept_names.size();
  if (!is_begun) // no row, so it may have other columns
    kept_names.clear();
  if (text.compare(0, kept.size(), kept) != 0)
    return replace_text_file(path, kept);
  // Rows that go are the last ones, as a rule; then the file needs no more room, which a full disk may not have.
  std::error_code error;
  if (kept.size() < text.size())
    std::filesystem::resize_file(path, kept.size(), error);
  if (error || ::access(path.c_str(), W_OK) != 0)
    throw FileError(path, "cannot be continued; check that it may be written");
}

void BodyHistory::append(const RigidSystems& bodies, const std::vector<Vector6>& reactions, double time,
                         unsigned int stage, unsigned int step)
{
  if (line_of_names.empty())
    line_of_names = fmt::format("{}\n", fmt::join(history_columns(bodies, fields), ","));
  if (!kept_names.empty() && kept_names != line_of_names)
    set_aside();
  kept_names.clear();
  fmt::memory_buffer row;
  const auto end = fmt::appender(row);
  fmt::format_to(end, "{}", time);
  double value[3];
  for (std::size_t i = 0; i < bodies.points.size(); ++i)
    for (const BodyField& field : fields)
    {
      field.evaluate(bodies.points[i], reaction_on(reactions, i), value);
      fmt::format_to(end, ",{}", fmt::join(value, value + field.n_components, ","));
    }
  for (const TrackedNode& node : bodies.tracked)
  {
    const Eigen::Vector3d x = bodies.points[node.point].pose.to_world(node.position);
    fmt::format_to(end, ",{},{},{}", x[0], x[1], x[2]);
  }
  for (const Joint& joint : bodies.joints)
  {
    const auto [a, b] = joint.points;
    const JointForce on_first = joint_force(joint, {bodies.points[a].pose, bodies.points[b].pose});
    for (const Eigen::Vector3d& x : {on_first.force, on_first.couple})
      fmt::format_to(end, ",{},{},{}", x[0], x[1], x[2]);
  }
  fmt::format_to(end, ",{},{}\n", stage, step);
  if (waiting.empty() || waiting.size() + row.size() <= most_bytes)
    waiting.append(row.data(), row.size());
  else
    ++n_lost;
  write(); // A row must survive even if the run crashes.
}

/// The table of the earlier run, whose columns are others.
void BodyHistory::set_aside()
{
  const std::filesystem::path table(path);
  std::string name;
  for (unsigned int i = 1; name.empty() || std::filesystem::exists(name); ++i)
    name =
        (table.parent_path() / fmt::format("{}-{}{}", table.stem().string(), i, table.extension().string())).string();
  std::error_code error;
  std::filesystem::rename(path, name, error);
  if (error)
    throw FileError(path, "has other columns than this run and cannot be renamed: " + error.message());
  is_begun = false;
  earlier_table = name;
}

unsigned int BodyHistory::count_waiting() const
{
  return n_lost + static_cast<unsigned int>(std::count(waiting.begin(), waiting.end(), '\n'));
}

void BodyHistory::write()
{
  if (waiting.empty())
    return;
  if (is_begun && ::access(path.c_str(), F_OK) == 0)
    append_text(path, waiting);
  else // also where somebody has taken the table away, for room on the disk
    replace_text_file(path, line_of_names + waiting);
  is_begun = true;
  waiting.clear();
}
} // namespace kedge
