#include <kedge/geometry/command.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <functional>
#include <kedge/base/report.h>
#include <kedge/geometry/ac14.h>
#include <kedge/geometry/generators.h>

namespace kedge
{
namespace
{
/// Facets over a turn or a part of it: a sphere of so many has four million triangles.
constexpr unsigned int most_segments = 1000;

/// Options of every body: file, translation and density.
struct Target
{
  std::string file;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double density = 0.;
};

/// Dimensions of all bodies; each subcommand reads its own.
struct Dimensions
{
  double side = 0.1, thickness = 0.01;
  double major_diameter = 0.1, minor_diameter = 0.05;
  double radius = 0.01785, apex_angle = 60., length = 0.1;
  Eigen::Vector3d size = Eigen::Vector3d::Constant(0.1);
  unsigned int sides = 48, sphere_segments = 12;
  Rounding rounding{0., 4};
  std::string part = "fluke";
  Ac14Fluke fluke;
  Ac14Shank shank;
  PartMesh part_mesh;
};

std::string describe(const TriangleMesh& mesh, const Target& target)
{
  const MassProperties properties = mass_properties(mesh);
  const auto [lower, upper] = bounds(mesh);
  const auto& c = properties.centroid;
  // Products of inertia that vanish by symmetry are printed as 0, not as round-off.
  const double round_off = 1e-14 * properties.inertia.norm();
  const auto inertia = [&](double factor)
  {
    const Eigen::Matrix3d tensor =
        (properties.inertia.array().abs() < round_off).select(0., factor * properties.inertia);
    std::string text;
    for (int i = 0; i < 3; ++i)
      text += fmt::format("\n    {:14.6e} {:14.6e} {:14.6e}", tensor(i, 0), tensor(i, 1), tensor(i, 2));
    return text;
  };
  std::string text = fmt::format("{}: {} triangles\n", target.file, mesh.triangles.size());
  text += fmt::format("  extent    {:.6g} to {:.6g}, {:.6g} to {:.6g}, {:.6g} to {:.6g} m\n", lower[0], upper[0],
                      lower[1], upper[1], lower[2], upper[2]);
  const double sharpest = Surface(mesh).sharpest_edge_radius();
  text += std::isinf(sharpest) ? "  edges     none\n"
          : sharpest == 0.     ? "  edges     sharp\n"
                               : fmt::format("  edges     rounded with {:.3g} m or more\n", sharpest);
  text += fmt::format("  volume    {:.6g} m3\n  area      {:.6g} m2\n", properties.volume, properties.area);
  text += fmt::format("  centroid  ({:.6g}, {:.6g}, {:.6g}) m\n", c[0], c[1], c[2]);
  text += "  inertia tensor about the centroid per unit density, m5" + inertia(1.);
  if (target.density > 0.)
    text += fmt::format("\n  mass      {:.6g} kg\n  inertia tensor about the centroid, kg m2",
                        target.density * properties.volume) +
            inertia(target.density);
  return text;
}

void write(TriangleMesh mesh, const Target& target)
{
  for (Eigen::Vector3d& x : mesh.vertices)
    x += target.translation;
  write_stl(mesh, target.file);
  Report(true, false).line(describe(mesh, target));
}

/// Three numbers x y z.
void add_vector(CLI::App& body, const std::string& name, Eigen::Vector3d& value, const std::string& meaning)
{
  const auto assign = [&value](const std::vector<double>& x) { value = {x[0], x[1], x[2]}; };
  body.add_option_function<std::vector<double>>(name, assign, meaning)
      ->expected(3)
      ->check(CLI::Number)
      ->check(CLI::Validator(
          [](const std::string& text)
          { return std::isfinite(std::strtod(text.c_str(), nullptr)) ? std::string() : text + " is not finite"; },
          "FINITE"))
      ->default_str(fmt::format("{:g} {:g} {:g}", value[0], value[1], value[2]));
}

/// Adds one body; `make` is called when its subcommand has been parsed.
CLI::App* add_body(CLI::App& geometry, const std::string& name, const std::string& description,
                   const std::shared_ptr<Dimensions>& dimensions,
                   const std::function<TriangleMesh(const Dimensions&)>& make)
{
  CLI::App* body = geometry.add_subcommand(name, description);
  const auto target = std::make_shared<Target>();
  target->file = name + ".stl";
  body->add_option("--output", target->file, "STL file to write")->capture_default_str();
  add_vector(*body, "--translate", target->translation, "move the body by x y z [m]");
  body->add_option("--density", target->density, "also print mass and inertia for this density [kg/m3]")
      ->check(CLI::PositiveNumber);
  body->callback([=] { write(make(*dimensions), *target); });
  return body;
}

void add_rounding(CLI::App& body, Dimensions& dimensions, const std::string& edges = "convex edges")
{
  body.add_option("--edge-radius", dimensions.rounding.radius,
                  "radius of " + edges + ", at least half the smallest material point; 0: sharp [m]")
      ->capture_default_str();
  body.add_option("--edge-segments", dimensions.rounding.segments, "facets over a quarter turn of the rounding")
      ->check(CLI::Range(1U, most_segments))
      ->capture_default_str();
}

void add_length(CLI::App& body, const std::string& name, double& value, const std::string& meaning)
{
  body.add_option(name, value, meaning)->capture_default_str();
}

void add_sides(CLI::App& body, Dimensions& dimensions)
{
  body.add_option("--sides", dimensions.sides, "facets around the axis")
      ->check(CLI::Range(3U, most_segments))
      ->capture_default_str();
}

void add_plate(CLI::App& geometry, const std::shared_ptr<Dimensions>& d)
{
  const auto make = [](const Dimensions& d) { return make_plate(d.side, d.thickness, d.rounding); };
  CLI::App& plate = *add_body(geometry, "plate", "Square plate across x, centred at the origin", d, make);
  add_length(plate, "--side", d->side, "side of the square [m]");
  add_length(plate, "--thickness", d->thickness, "thickness along x [m]");
  add_rounding(plate, *d);
}

void add_frustum(CLI::App& geometry, const std::shared_ptr<Dimensions>& d)
{
  const auto make = [](const Dimensions& d)
  { return make_frustum(d.major_diameter, d.minor_diameter, d.length, d.sides, d.rounding); };
  CLI::App& frustum = *add_body(geometry, "frustum", "Frustum of a cone along x, major base at x = 0", d, make);
  add_length(frustum, "--major-diameter", d->major_diameter, "diameter of the base at x = 0 [m]");
  add_length(frustum, "--minor-diameter", d->minor_diameter, "diameter of the base at x = length [m]");
  add_length(frustum, "--length", d->length, "length along x [m]");
  add_sides(frustum, *d);
  add_rounding(frustum, *d);
}

void add_cone(CLI::App& geometry, const std::shared_ptr<Dimensions>& d)
{
  const auto make = [](const Dimensions& d)
  { return make_cone(d.radius, d.apex_angle, d.length, d.sides, d.rounding); };
  CLI::App& cone = *add_body(geometry, "cone", "Cone penetrometer along z, tip at the origin pointing down", d, make);
  add_length(cone, "--radius", d->radius, "radius of the shaft; the default is that of a 10 cm2 cone [m]");
  cone.add_option("--apex-angle", d->apex_angle, "full angle of the tip [degrees]")->capture_default_str();
  add_length(cone, "--length", d->length, "length from the tip to the top [m]");
  add_sides(cone, *d);
  add_rounding(cone, *d, "tip, shoulder and top edge");
}

void add_sphere(CLI::App& geometry, const std::shared_ptr<Dimensions>& d)
{
  const auto make = [](const Dimensions& d) { return make_sphere(d.radius, d.sphere_segments); };
  CLI::App& sphere = *add_body(geometry, "sphere", "Sphere centred at the origin", d, make);
  add_length(sphere, "--radius", d->radius, "radius [m]");
  sphere.add_option("--segments", d->sphere_segments, "facets over a quarter of a great circle")
      ->check(CLI::Range(1U, most_segments))
      ->capture_default_str();
}

void add_box(CLI::App& geometry, const std::shared_ptr<Dimensions>& d)
{
  const auto make = [](const Dimensions& d) { return make_box(d.size, d.rounding); };
  CLI::App& box = *add_body(geometry, "box", "Box along the axes, centred at the origin", d, make);
  add_vector(box, "--size", d->size, "size along x y z [m]");
  add_rounding(box, *d);
}

void add_ac14(CLI::App& geometry, const std::shared_ptr<Dimensions>& d)
{
  const auto make = [](const Dimensions& d)
  { return d.part == "fluke" ? make_ac14_fluke(d.fluke, d.part_mesh) : make_ac14_shank(d.shank, d.part_mesh); };
  const std::string description = "A part of the AC-14 drag anchor of 8700 kg along x, pivot at x = 0.489, y = z = 0";
  CLI::App& ac14 = *add_body(geometry, "ac14", description, d, make);
  ac14.add_option("--part", d->part, "fluke (crown and both flukes) or shank")
      ->check(CLI::IsMember({"fluke", "shank"}))
      ->capture_default_str();
  add_length(ac14, "--crown-width", d->fluke.crown_width, "width of the crown; thickness follows from the mass [m]");
  add_length(ac14, "--slot-width", d->fluke.slot_width, "width of the slot between the flukes [m]");
  add_length(ac14, "--palm-height", d->fluke.palm_height, "height of the tripping palms over the crown [m]");
  add_length(ac14, "--eye-radius", d->shank.eye_radius, "radius of the hole in the shank's eye; 0: none [m]");
  add_length(ac14, "--size", d->part_mesh.size, "edges of the triangles on flat sides [m]");
  ac14.add_option("--edge-segments", d->part_mesh.segments, "facets over a quarter turn of roundings")
      ->check(CLI::Range(1U, most_segments))
      ->capture_default_str();
  ac14.parse_complete_callback(
      [&ac14, d]
      {
        const bool fluke = d->part == "fluke";
        for (const std::string name : {"--crown-width", "--slot-width", "--palm-height", "--eye-radius"})
          if (ac14.count(name) > 0 && fluke == (name == "--eye-radius"))
            throw CLI::ValidationError(name, fmt::format("belongs to the {}", fluke ? "shank" : "fluke"));
      });
}
} // namespace

void add_geometry_command(CLI::App& app)
{
  CLI::App& geometry = *app.add_subcommand("geometry", "Write a body as an STL file and print its mass properties");
  geometry.require_subcommand(0, 1); // CLI11 names a word that is no body only where it does not miss one
  geometry.final_callback(
      [&geometry]
      {
        if (geometry.get_subcommands().empty())
          throw CLI::RequiredError::Subcommand(1);
      });
  const auto dimensions = std::make_shared<Dimensions>();
  add_plate(geometry, dimensions);
  add_frustum(geometry, dimensions);
  add_cone(geometry, dimensions);
  add_sphere(geometry, dimensions);
  add_box(geometry, dimensions);
  add_ac14(geometry, dimensions);
}
} // namespace kedge
