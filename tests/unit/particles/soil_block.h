// A block of soil whose cells, particles and states the tests of splitting, merging and cleaning change.
#pragma once

#include "../soil_fixture.h"
#include <Eigen/LU>
#include <algorithm>
#include <map>

namespace kedge::test
{
/// What one particle carries, as a parcel between ranks.
template <int dim> struct ParticleRecord
{
  long long id;
  std::array<double, dim> position;
  std::array<double, field::count> data;

  Eigen::Map<const Eigen::Vector3d> vector(const unsigned int offset) const
  {
    return Eigen::Map<const Eigen::Vector3d>(data.data() + offset);
  }
  Eigen::Matrix3d F() const
  {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data.data() + field::deformation_gradient);
  }
};

/// Two layers, 0.4 and 0.85 m thick, in 4 (by 4) by 4 cells of 0.5 m with 2 particles per axis; the interface cuts a
/// row of particles. Stiffness grows with depth, Poisson's ratio is 1/4.
template <int dim> struct SoilBlock : SoilFixture<dim>
{
  using Record = ParticleRecord<dim>;
  using SoilFixture<dim>::particles;

  explicit SoilBlock(const MPI_Comm communicator = MPI_COMM_WORLD)
      : SoilFixture<dim>(layout(), two_layers(), 10., {}, communicator)
  {
  }

  static MaterialPointParameters two_layers()
  {
    MaterialPointParameters parameters = layers_of({elastic_layer(0.4, 1500.), elastic_layer(0.85, 2000.)}, 0.4);
    for (Layer& layer : parameters.layers)
      layer.material.overburden = Overburden{1e4, 0.5};
    return parameters;
  }

  static GridLayout<dim> layout()
  {
    std::array<unsigned int, dim> cells;
    cells.fill(4);
    GridLayout<dim> grid = make_brick<dim>(cells, 0.5);
    grid.soil_extent[dim - 1] = 1.25;
    return grid;
  }

  /// Gives every particle a deformation, domain, stress and motion of its own, the same on any number of ranks.
  void disturb()
  {
    for (auto& particle : particles.edit())
    {
      double* data = particle.get_properties().data();
      const auto random = [&](const unsigned int salt) { return 2. * noise(particle.get_id(), salt) - 1.; };
      for (unsigned int i = 0; i < dim; ++i)
      {
        for (unsigned int j = 0; j < dim; ++j)
          data[field::deformation_gradient + 3 * i + j] = i == j ? 1. + 0.03 * random(i) : 0.2 * random(3 * i + j);
        data[field::half_width + i] = data[field::initial_half_width + i] * data[field::deformation_gradient + 4 * i];
        data[field::velocity + i] = 0.01 * random(10 + i); // slow: merging keeps what moves
        data[field::acceleration + i] = random(20 + i);
      }
      for (unsigned int i = 0; i < 6; ++i)
        data[field::elastic_strain + i] *= 1. + 0.1 * random(30 + i);
      set_stress(data);
      data[field::plastic_strain] = random(40) + 1.;
      for (unsigned int k = 0; k < Laws::max_state; ++k)
        data[field::law_state + k] = random(50 + k) + 1.;
    }
  }

  /// Hencky's law for Poisson's ratio 1/4, where both Lame constants are 0.4 E.
  static void set_stress(double* data)
  {
    const double* strain = data + field::elastic_strain;
    for (unsigned int i = 0; i < 6; ++i)
      data[field::stress + i] =
          0.4 * data[field::young] * (2. * strain[i] + (i < 3 ? strain[0] + strain[1] + strain[2] : 0.));
  }

  /// The particles of all ranks, in the order of their numbers.
  std::vector<Record> records() const
  {
    std::vector<Record> mine;
    for (const auto& particle : particles.handler())
    {
      Record record;
      record.id = particle.get_id();
      for (unsigned int d = 0; d < dim; ++d)
        record.position[d] = particle.get_location()[d];
      std::copy_n(particle.get_properties().data(), field::count, record.data.begin());
      mine.push_back(record);
    }
    std::vector<Record> all = gather_everywhere(mine, this->soil.communicator());
    std::sort(all.begin(), all.end(), [](const Record& a, const Record& b) { return a.id < b.id; });
    return all;
  }

  std::map<long long, Record> by_number() const
  {
    std::map<long long, Record> result;
    for (const Record& record : records())
      result[record.id] = record;
    return result;
  }

  /// Everything that splitting and merging must keep, added up: mass, momentum, moment of mass, volumes, V0 tau.
  Eigen::VectorXd totals() const
  {
    Eigen::Matrix<long double, Eigen::Dynamic, 1> sum = Eigen::Matrix<long double, Eigen::Dynamic, 1>::Zero(13 + dim);
    for (const Record& record : records())
    {
      const double mass = record.data[field::mass], volume = record.data[field::initial_volume];
      double domain = 1.;
      for (unsigned int d = 0; d < dim; ++d)
      {
        domain *= 2. * record.data[field::half_width + d];
        sum[13 + d] += static_cast<long double>(mass) * record.position[d];
      }
      sum[0] += mass;
      sum[1] += volume;
      sum[2] += domain;
      sum[3] += static_cast<long double>(volume) * record.F().determinant();
      for (unsigned int d = 0; d < 3; ++d)
        sum[4 + d] += static_cast<long double>(mass) * record.data[field::velocity + d];
      for (unsigned int i = 0; i < 6; ++i)
        sum[7 + i] += static_cast<long double>(volume) * record.data[field::stress + i];
    }
    return sum.template cast<double>();
  }
};

/// The largest difference between sums, over each quantity's largest entry (mass, volumes, momentum, stress, moment).
inline double largest_difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
{
  double worst = 0.;
  for (const auto& [first, count] : std::vector<std::pair<int, int>>{
           {0, 1}, {1, 1}, {2, 1}, {3, 1}, {4, 3}, {7, 6}, {13, static_cast<int>(a.size()) - 13}})
    worst = std::max(worst, (a - b).segment(first, count).lpNorm<Eigen::Infinity>() /
                                a.segment(first, count).lpNorm<Eigen::Infinity>());
  return worst;
}
} // namespace kedge::test
