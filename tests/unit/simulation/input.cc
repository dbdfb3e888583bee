#include "input_files.h"
#include <cmath>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/materials/laws.h>
#include <kedge/parameters/json.h>
#include <kedge/simulation/input.h>

using namespace kedge;
using schema::Json;

namespace
{
const input_files::Folder files;

std::string drag_anchor()
{
  return input_files::contents(input_files::root() / "tests/unit/simulation/data/drag_anchor.json");
}

Input base_with(const std::vector<std::string>& overrides)
{
  return parse_input(input_files::contents(input_files::root() / "tests/bad_input/base.json"), files.path.string(),
                     "base.json", overrides);
}

/// Path of the InputError that `action` throws.
template <typename Action> std::string path_refused(const Action& action)
{
  try
  {
    action();
  }
  catch (const InputError& error)
  {
    return error.path;
  }
  return "nothing was refused";
}

const char* const flat_scene = R"({
  "GPU": "off", "dimension": 2, "domain": {"size": 4, "gravity": [0, -9.81]},
  "material points": {"extra capacity": 1, "element size": 0.5, "number of material points per element 1": 2,
    "material size": {"max": [4]},
    "layers": [{"thickness": 2, "material": {"type": "elastic", "E": 1e6, "nu": 0.3, "density": 1500}}]},
  "rigid bodies": [{
    "points": [{"position": [2, 3], "mass": 10, "rotational inertia": [5],
                "boundary conditions": ["fixed", {"prescribed": -0.01}, "free"]}],
    "outline": [{"polygon": [[1, 3], [3, 3], [2, 4]], "point": 1}], "offset": [0.5, 1]}],
  "contact": {"friction coefficient": 0},
  "analysis": [{"type": "static", "load steps": 1, "load": "full", "rigid bodies": "on",
    "boundary conditions": {"min": ["roller", "fixed"], "max": ["roller", "free"]}}],
  "solver": {"tolerance": 1e-6, "max newton iterations": 20, "poor factor": 0, "ghost factor": 0,
             "ghost factor mass": 0},
  "output": {"vtk": "off", "csv": "off"}})";
} // namespace

TEST(DragAnchorInput, SoilIsRead)
{
  const Input input = parse_input(drag_anchor(), files.path.string());
  EXPECT_TRUE(input.gpu);
  EXPECT_EQ(input.dimension, 3u);
  EXPECT_EQ(input.gravity, (std::array<double, 3>{0., 0., -9.81}));
  EXPECT_EQ(input.material_points.plan_extent, (std::array<double, 2>{100., 10.}));
  ASSERT_EQ(input.material_points.layers.size(), 1u);
  EXPECT_EQ(input.material_points.layers[0].thickness, 18.123);
  const MaterialParameters& sand = input.material_points.layers[0].material;
  EXPECT_EQ(sand.law, law_index<WillamWarnke>);
  EXPECT_EQ(sand.constants[law_keys::friction_angle], 28.5);
  EXPECT_TRUE(std::isnan(sand.constants[law_keys::yield_stress]));
  ASSERT_TRUE(sand.overburden);
  EXPECT_EQ(sand.overburden->exponent, 0.6875);
  EXPECT_FALSE(input.material_points.K0);
}

TEST(DragAnchorInput, AnchorIsRead)
{
  const Input input = parse_input(drag_anchor(), files.path.string());
  ASSERT_EQ(input.systems.size(), 1u);
  const SystemParameters& anchor = input.systems[0];
  ASSERT_EQ(anchor.points.size(), 3u);
  EXPECT_EQ(anchor.points[1].inertia[2], 337.5);
  EXPECT_EQ(anchor.points[0].conditions[4].kind, DofCondition::Kind::free);
  EXPECT_EQ(anchor.points[0].conditions[5].kind, DofCondition::Kind::fixed);
  ASSERT_EQ(anchor.joints.size(), 3u);
  EXPECT_EQ(anchor.joints[1].type, JointType::stop);
  EXPECT_EQ(anchor.joints[1].angle_limit, 35.);
  EXPECT_EQ(anchor.joints[2].points, (std::array<unsigned int, 2>{2, 3}));
  ASSERT_EQ(anchor.surfaces.size(), 2u);
  EXPECT_EQ(anchor.surfaces[1].stl, (files.path / "shank_scv2.stl").string());
  EXPECT_EQ(anchor.surfaces[1].point, 2u);
  EXPECT_EQ(anchor.offset[0], 1.);
}

TEST(DragAnchorInput, StagesAreRead)
{
  const Input input = parse_input(drag_anchor(), files.path.string());
  ASSERT_EQ(input.stages.size(), 3u);
  EXPECT_EQ(input.stages[0].stepping.load, GravityLoad::ramp);
  EXPECT_EQ(input.stages[0].adaptivity.type, AdaptivityType::uniform);
  EXPECT_EQ(input.stages[0].boundary_conditions.min[2], FaceCondition::fixed);
  EXPECT_TRUE(input.stages[1].surface_placement);
  EXPECT_EQ(input.stages[1].stepping.dt, 5e-3);
  const Stage& drag = input.stages[2];
  EXPECT_EQ(drag.stepping.type, StageType::dynamic);
  EXPECT_EQ(drag.stepping.gamma, 1.);
  EXPECT_EQ(drag.adaptivity.element_size, 0.1);
  ASSERT_EQ(drag.point_conditions.size(), 1u);
  EXPECT_EQ(drag.point_conditions[0].point, 3u);
  EXPECT_EQ(drag.point_conditions[0].conditions[0].increment, 0.008);
  EXPECT_EQ(drag.track.min[0].type, FaceCondition::fixed);
  EXPECT_TRUE(drag.track.min[0].remove);
  EXPECT_EQ(drag.track.max[0].distance, 5.);
  EXPECT_FALSE(drag.track.max[1].type);
}

TEST(DragAnchorInput, SolverAndOutputAreRead)
{
  const Input input = parse_input(drag_anchor(), files.path.string());
  EXPECT_EQ(input.solver.ghost_factor, 0.025);
  EXPECT_EQ(input.solver.max_linear_iterations, 100u);
  EXPECT_TRUE(input.output.vtk.on);
  EXPECT_EQ(input.output.vtk.percent, 0.25);
  EXPECT_EQ(input.output.csv.body_fields.back(), "reaction moment");
}

TEST(DragAnchorInput, AsksForNothingThatIsNotAvailable)
{
  const Input input = parse_input(drag_anchor(), files.path.string());
  EXPECT_NO_THROW(refuse_unavailable_features(input));
}

TEST(Input, AbsentFieldListMeansEveryFieldAndEmptyListNone)
{
  const Input input = base_with({"output.csv rigid body fields=[]"});
  EXPECT_EQ(input.output.csv.particle_fields, particle_field_names());
  EXPECT_TRUE(input.output.csv.body_fields.empty());
}

TEST(Input, BodyKeysHaveNoEffectInStageWithoutBodies)
{
  const Input input = base_with({"analysis.0.rigid body surface placement=on", "analysis.0.wished in place=on",
                                 "analysis.0.adaptivity={\"type\": \"rigid body surface\", \"element size\": 0.25}",
                                 "analysis.0.rigid body boundary conditions=[{\"system\": 9, \"point\": 9, \"boundary "
                                 "conditions\": [\"free\", \"free\", \"free\", \"free\", \"free\", \"free\"]}]"});
  const Stage& stage = input.stages[0];
  EXPECT_FALSE(stage.surface_placement);
  EXPECT_FALSE(stage.wished_in_place);
  EXPECT_TRUE(stage.point_conditions.empty());
  EXPECT_EQ(stage.adaptivity.type, AdaptivityType::none);
  EXPECT_NO_THROW(refuse_unavailable_features(input));
}

TEST(Input, DomainUpdateSurvivesMaterialPointsSection)
{
  EXPECT_EQ(base_with({"domain update=stretch"}).material_points.domain_update, DomainUpdate::stretch);
}

TEST(Input, InitialStressIsRead)
{
  const Input input =
      base_with({"material points.initial stress={\"type\": \"K0\", \"K0\": 0.426}", "analysis.0.load=full"});
  EXPECT_EQ(input.material_points.K0, 0.426);
}

TEST(Input, ExplicitStageFindsItsStep)
{
  const std::string stage = "analysis.0={\"type\": \"explicit\", \"rigid bodies\": \"off\", \"final time\": 1, ";
  EXPECT_EQ(base_with({stage + "\"dt\": \"auto\", \"cfl\": 0.5}"}).stages[0].stepping.dt, 0.);
  EXPECT_EQ(base_with({stage + "\"dt\": 0.25}"}).stages[0].stepping.dt, 0.25);
}

TEST(Input, CheckpointIntervalIsStepsOrTime)
{
  EXPECT_EQ(base_with({}).output.checkpoint_every, "");
  EXPECT_EQ(base_with({"output.checkpoint every=50"}).output.checkpoint_every, "50");
  EXPECT_EQ(base_with({"output.checkpoint every=10 min"}).output.checkpoint_every, "10 min");
}

TEST(Input, EffectiveDocumentHoldsOverrides)
{
  const Input input = base_with({"solver.tolerance=1e-4", "comment=coarse"});
  const Json document = Json::parse(input.effective_json);
  EXPECT_EQ(document.at("solver").at("tolerance"), 1e-4);
  EXPECT_EQ(document.at("comment"), "coarse");
  EXPECT_EQ(input.solver.tolerance, 1e-4);
  EXPECT_NO_THROW(parse_input(input.effective_json, files.path.string()));
}

TEST(Input, FileNamesAreRelativeToInputFile)
{
  std::ofstream(files.path / "input_data.json") << drag_anchor();
  const Input input = read_input((files.path / "input_data.json").string(), {"contact.friction coefficient=0.1"});
  EXPECT_EQ(input.contact.interface.friction_coefficient, 0.1);
  EXPECT_EQ(input.systems[0].surfaces[0].stl, (files.path / "fluke_round_nose.stl").string());
}

TEST(Input, MissingFileIsNamed)
{
  EXPECT_EQ(path_refused([] { read_input("nowhere.json"); }), "nowhere.json");
}

TEST(FlatInput, VectorsAreXAndZ)
{
  const Input input = parse_input(flat_scene, "");
  EXPECT_EQ(input.gravity, (std::array<double, 3>{0., -9.81, 0.}));
  EXPECT_EQ(input.material_points.plan_extent[0], 4.);
  const SystemParameters& system = input.systems[0];
  EXPECT_EQ(system.points[0].inertia[0], 5.);
  EXPECT_EQ(system.points[0].conditions[1].kind, DofCondition::Kind::prescribed);
  EXPECT_EQ(system.points[0].conditions[2].kind, DofCondition::Kind::free);
  ASSERT_EQ(system.surfaces.size(), 1u);
  EXPECT_EQ(system.surfaces[0].outline[2], (std::array<double, 2>{2., 4.}));
  EXPECT_EQ(system.offset[1], 1.);
  EXPECT_EQ(input.stages[0].boundary_conditions.min[1], FaceCondition::fixed);
}

TEST(FlatInput, IsAvailable)
{
  const Input input = parse_input(flat_scene, "");
  EXPECT_NO_THROW(refuse_unavailable_features(input));
}

TEST(FlatInput, RefusesThreeEntries)
{
  EXPECT_EQ(path_refused([] { parse_input(flat_scene, "", "flat", {"domain.gravity=[0, 0, -9.81]"}); }),
            "domain.gravity");
}

TEST(FlatInput, RefusesStlFile)
{
  const std::string file = "rigid bodies.0.stl files=[{\"stl\": \"body.stl\", \"point\": 1}]";
  EXPECT_EQ(path_refused([&] { parse_input(flat_scene, files.path.string(), "flat", {file}); }),
            "rigid bodies[0].stl files[0]");
}

TEST(FlatInput, RefusesHinge)
{
  const std::string hinge =
      R"(rigid bodies.0.constraints=[{"type": "rotation lock", "points": [1, 1], "stiffness": 1, "rotational stiffness": 1,
       "rotation centre": [0, 0], "direction 1": [0, 1], "direction 2": [0, 1]}])";
  EXPECT_EQ(path_refused([&] { parse_input(flat_scene, "", "flat", {hinge}); }), "rigid bodies[0].constraints[0].type");
}
