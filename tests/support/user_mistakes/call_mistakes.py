"""Mistakes on the command line: wrong files, names, options and places to write to."""

from __future__ import annotations

from support.user_mistakes.mistake import Mistake

MOVE = "plan-move --scene SCENE --from home --to bin_C -o OUT"
PICK = "plan-pick --scene SCENE --bin bin_C --item dove_beauty_bar -o OUT"
FARTHER = (("clearance: 0.003", "clearance: 0.004"),)

CALL_MISTAKES = (
    Mistake(
        "a plan as scene",
        "verify PLAN --scene PLAN",
        "plan.json: is a plan, but a scene is wanted here (apc make-scene makes one from an order)",
        3,
    ),
    Mistake(
        "a scene as plan",
        "verify SCENE --scene SCENE",
        "scene.json: is a scene, but a plan is wanted here (apc plan-pick or apc plan-move makes one)",
        3,
    ),
    Mistake(
        "a scene as roadmap",
        MOVE + " --roadmap SCENE",
        "scene.json: is a scene, but a roadmap or … or apc build-trajectories makes one)",
        3,
    ),
    Mistake(
        "a scene as order",
        "run-trial SCENE -o OUT",
        "scene.json: is a scene, but an order is … makes one, others are under data/tasks)",
        3,
    ),
    Mistake(
        "an order as scene",
        "plan-move --scene ORDER --from home --to bin_C -o OUT",
        "order.json: is an order, but a scene is wanted here (apc make-scene makes one from an order)",
        3,
    ),
    Mistake(
        "a cell as scene",
        "plan-move --scene CELL --from home --to bin_C -o OUT",
        "cell: is a folder, not a regular file; check … (apc make-scene makes one from an order)",
        3,
    ),
    Mistake(
        "items as cell",
        "check ITEMS --cell apc2016_delft",
        "--cell is of no use for a file of items; leave it out",
        2,
    ),
    Mistake(
        "check a plan",
        "check PLAN",
        "plan.json: is a plan, but a cell, a scene, an … is wanted here (apc verify checks plans)",
        3,
    ),
    Mistake(
        "refresh a scene",
        "refresh SCENE",
        "scene.json: is a scene, but a roadmap or … or apc build-trajectories makes one)",
        3,
    ),
    Mistake(
        "inspect an order",
        "inspect ORDER",
        "order.json: is an order, but a roadmap, … plan, scene or cell is wanted here",
        3,
    ),
    Mistake(
        "execute a scene",
        "execute SCENE --scene SCENE",
        "scene.json: is a scene, but a plan is wanted here (apc plan-pick or apc plan-move makes one)",
        3,
    ),
    Mistake(
        "repair a scene",
        "check SCENE --repair",
        "--repair is for roadmaps and trajectory databases; edit this file instead",
        2,
    ),
    Mistake(
        "a picture of a scene's reach",
        "check SCENE --picture reach.png",
        "--picture draws what is reached in a cell; leave it out",
        2,
    ),
    Mistake(
        "a picture in a format that is not drawn",
        "check CELL --picture reach.jpg",
        "reach.jpg: a picture is written as .png or .html; name such a file",
        3,
    ),
    Mistake(
        "strict over a roadmap",
        "check missing.h5 --strict",
        "missing.h5: no such file … apc2016_delft",
        3,
    ),
    Mistake(
        "a file that is not there",
        "check missing.json",
        "missing.json: no such file, and no cell of that name; known: … apc2016_delft",
        3,
    ),
    Mistake(
        "a cell that is not there",
        "check apc2016_delf",
        "no such file, and no cell of that name; did you mean 'apc2016_delft'?",
        3,
    ),
    Mistake(
        "the output over the input",
        "plan-move --scene SCENE --from home --to bin_C -o SCENE --overwrite",
        "is what this command reads … name another file",
        3,
    ),
    Mistake(
        "an output in no folder",
        MOVE.replace("OUT", "nowhere/out.json"),
        "nowhere/out.json: the folder nowhere does not exist; make it first, or name another",
        3,
    ),
    Mistake("an output that is a folder", MOVE.replace("OUT", "."), ".: is a folder; name a file in it", 3),
    Mistake(
        "no output",
        MOVE.replace(" -o OUT", ""),
        "Missing option '-o' / '--output'. FILE: Where to write the plan.",
        2,
    ),
    Mistake(
        "an empty path",
        "check -",
        "Invalid value for 'FILE': files are not read from stdin nor written to stdout; name a file",
        2,
    ),
    Mistake(
        "an unknown command",
        "plan_pick --scene SCENE",
        "unknown command 'plan_pick'; did you mean 'plan-pick'?",
        2,
    ),
    Mistake(
        "an unknown option",
        MOVE + " --sed 3",
        "No such option '--sed'. (Did you mean one of: '--scene', '--seed'?)",
        2,
    ),
    Mistake("an option twice", MOVE + " --seed 3 --seed 4", "--seed is given 2 times; keep one", 2),
    Mistake(
        "a seed that is no number",
        MOVE + " --seed three",
        "Invalid value for '--seed': 'three' is not a valid whole number.",
        2,
    ),
    Mistake(
        "a negative seed",
        MOVE + " --seed -1",
        "Invalid value for '--seed': -1 is not in the range 0<=x<=2147483647.",
        2,
    ),
    Mistake(
        "no jobs",
        "build-roadmap --jobs 0 -o OUT",
        "Invalid value for '--jobs': 0 is not in the range 1<=x<=1024.",
        2,
    ),
    Mistake(
        "an unknown bin",
        PICK.replace("bin_C", "bin_M"),
        "--bin: unknown bin 'bin_M'; known: bin_A, … bin_H, bin_I, bin_J, bin_K, bin_L, tote",
        3,
    ),
    Mistake(
        "a bin by its letter", PICK.replace("bin_C", "C"), "--bin: unknown bin 'C'; did you mean 'bin_C'?", 3
    ),
    Mistake(
        "an unknown item",
        PICK.replace("beauty", "beuty"),
        "bin_C: unknown item 'dove_beuty_bar'; did you mean 'dove_beauty_bar'?",
        3,
    ),
    Mistake(
        "an item of another bin",
        PICK.replace("bin_C", "bin_A"),
        "bin_A: unknown item 'dove_beauty_bar'; it is in bin_C",
        3,
    ),
    Mistake(
        "a place that the item is in",
        PICK + " --into bin_C",
        "--into: the item is taken from bin_C; name the tote or another bin",
        3,
    ),
    Mistake(
        "an unknown place",
        PICK + " --into shelf",
        "--into: unknown place 'shelf'; known: bin_A, … bin_H, bin_I, bin_J, bin_K, bin_L, tote",
        3,
    ),
    Mistake(
        "an unknown configuration",
        MOVE.replace("home", "hom"),
        "unknown configuration 'hom'; did you mean 'home'?",
        3,
    ),
    Mistake(
        "a configuration of too few numbers",
        MOVE.replace("home", "0.1,0.2"),
        "configuration '0.1,0.2': got 2 of 8 numbers; … t_l,joint_e,joint_u,joint_r,joint_b,joint_t)",
        3,
    ),
    Mistake(
        "a configuration in degrees",
        MOVE.replace("home", "0.15,0,-17,0,-109,0,2,0"),
        "configuration '0.15,0,-17,0,-109,0,2,0': … 1.9198 rad; angles are in rad, not degrees",
        3,
    ),
    Mistake(
        "a configuration with decimal commas",
        MOVE.replace("home", "0,15;0;-0,3"),
        "configuration '0,15;0;-0,3': '15;0;-0' is not … t_l,joint_e,joint_u,joint_r,joint_b,joint_t)",
        3,
    ),
    Mistake(
        "neither scene nor cell",
        "plan-move --from home --to bin_C -o OUT",
        "what is around the robot? … with --scene, or with --cell a cell alone",
        2,
    ),
    Mistake(
        "a URDF as cell",
        "plan-move --cell CELL/robot.urdf --from home --to bin_C -o OUT",
        "cell/robot.urdf: is a URDF file, but a cell … of a cell.yaml, or a name under data/cells)",
        3,
    ),
    Mistake(
        "another cell than the scene's",
        MOVE + " --cell CELL",
        "scene.json: made for cell apc2016_delft …, but this is apc2016_delft …; make the scene again",
        4,
        cell=FARTHER,
    ),
    Mistake(
        "an order that nobody knows",
        "make-scene jsk_pick_sampel -o OUT",
        "unknown order 'jsk_pick_sampel'; did you mean 'jsk_pick_sample'?",
        3,
    ),
    Mistake(
        "an unknown planner",
        "build-roadmap --planner RRTX -o OUT",
        "Invalid value for '--planner': 'RRTX' is not … 'bitstar', 'aorrtc', 'rrt'.",
        2,
    ),
    Mistake(
        "pairs with a dash",
        "compare-planners --pairs bin_A-tote",
        "--pairs: 'bin_A-tote' is not a pair; write A:B,C:D with names of configurations",
        3,
    ),
    Mistake(
        "pose noise in m",
        "execute PLAN --scene SCENE --pose-noise 0.002",
        "No such option '--pose-noise'. Did you mean '--scene'?",
        2,
    ),
    Mistake(
        "pod shift in words",
        "make-scene ORDER --pod-shift left -o OUT",
        "Invalid value for '--pod-shift': 'left': … e.g. 20,-10,1.5, or random, or none",
        2,
    ),
    Mistake(
        "a state that the tool lacks",
        "suggest-configurations --bin bin_C --tool-state bent",
        "unknown state of the tool 'bent'; known: down, straight",
        3,
    ),
    Mistake(
        "suggest for the tote by a wrong name",
        "suggest-configurations --bin tot",
        "unknown bin 'tot'; known: bin_A, bin_B, … bin_G, bin_H, bin_I, bin_J, bin_K, bin_L",
        3,
    ),
    Mistake(
        "a stow of 2015",
        "make-order --task stow --year 2015 -o OUT",
        "there was no stow task in 2015; take one of pick 2015, pick 2016, stow 2016",
        3,
    ),
    Mistake(
        "a year without items",
        "make-order --task pick --year 2017 -o OUT",
        "Invalid value for '--year': '2017' is not one of '2015', '2016'.",
        2,
    ),
    Mistake(
        "a video that is no video",
        "execute PLAN --scene SCENE --video film.txt",
        "film.txt: films are animated GIFs; give the file a name ending in .gif",
        3,
    ),
    Mistake(
        "init from nothing",
        "init new_cell --urdf missing.urdf",
        "missing.urdf: no such file; check the name (the robot of a cell is one)",
        3,
    ),
    Mistake(
        "init over a folder",
        "init CELL --urdf CELL/robot.urdf",
        "cell: exists already; name another folder, or remove this one first",
        3,
    ),
    Mistake(
        "init with a limit of no joint",
        "init new_cell --urdf CELL/robot.urdf --max-jerk elbow=3",
        "--max-jerk: unknown joint 'elbow'; known: … joint_r, joint_s, joint_t, joint_u, rail",
        3,
    ),
    Mistake(
        "init with a limit of 0",
        "init new_cell --urdf CELL/robot.urdf --max-jerk 0",
        "--max-jerk 0: expected a number over 0, or JOINT= and one",
        3,
    ),
    Mistake(
        "init with a tip that is not there",
        "init new_cell --urdf CELL/robot.urdf --tip hand",
        "--tip: unknown link 'hand'; known: arm_base, … link_r, link_s, link_t, link_u, rail_base",
        3,
    ),
)
