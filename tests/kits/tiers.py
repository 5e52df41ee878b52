"""Which tests a run takes: the default one, `--all`, and `--slow`.

The default run is what a newcomer needs to trust the installation: of long files only what is listed here, one test
at least of each kind (a picture of each area, each backend, each output, each kind of error). `--all` takes the rest
too: matrices of variants, sweeps, long flights, numbers measured again. `--slow` adds tests marked slow. A file that is
named on the command line, with or without a test's name, is taken as by `--all`.
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterable
from pathlib import Path

import pytest

COLLECTED = pytest.StashKey[list[tuple[str, str]]]()
"""Of a run: (file, test) of all that was found, before any is left out."""

DEFAULT: dict[str, tuple[str, ...]] = {
    # a knob of the ground, one of the clouds and a printed method, there and back
    "test_retune.py": (
        "test_retuned_is_as_made_so[terrain.edge_px-grid]",
        "test_retuned_is_as_made_so[clouds.step_growth-clouds]",
        "test_retuned_is_as_made_so[terrain.edge_px-paper icosphere]",
    ),
    # whole pictures: one of each area; that files, pairs and names are complete
    "test_golden.py": (
        "test_picture_looks_as_it_did[earth/space]",
        "test_picture_looks_as_it_did[earth/ground]",
        "test_picture_looks_as_it_did[earth/sea]",
        "test_picture_looks_as_it_did[earth/dusk]",
        "test_picture_looks_as_it_did[earth/clouds]",
        "test_picture_looks_as_it_did[moon/near]",
        "test_picture_looks_as_it_did[knobs/tone_map_aces]",
        "test_every_golden_file_has_a_picture_and_its_settings",
        "test_the_named_views_all_have_goldens",
        "test_every_knob_has_a_pair",
        "test_knob_can_be_seen[composite.bloom]",
        "test_limits_notice_what_matters",
        "test_a_page_shows_all_three",
        "test_unknown_names_are_refused",
        "test_changes_are_put_back",
    ),
    "test_materials.py": (
        "test_albedos_are_natural",
        "test_every_knob_of_the_ground_and_the_water_is_tried",
        "test_the_open_sea_is_dark_and_blue",
    ),
    # many machines: a data set with a worker lost, and what is refused
    "test_farm.py": (
        "test_a_data_set_is_the_same_bytes_and_outlives_a_worker",
        "test_a_missing_extra_is_named",
        "test_scenes_travel_whole_or_not_at_all",
    ),
    # lenses: a single picture and faces all around, nothing blurred or shifted, no seam
    "test_lens_pictures.py": (
        "test_arrays_and_pick_lie_on_the_pixels_own_rays[brown]",
        "test_arrays_and_pick_lie_on_the_pixels_own_rays[panorama]",
        "test_a_lens_that_bends_nothing_shows_what_a_pinhole_does[temporal]",
        "test_a_panorama_has_no_seams",
        "test_refused_before_any_drawing",
    ),
    # the terrain's backends: no hole and the right heights for each, once
    "test_numbers_backends.py": ("test_no_holes", "test_the_hole_finder_finds_holes"),
    "test_numbers_ground.py": (
        "test_heights[near]",
        "test_land_and_heights_are_like_the_earths",
        "test_memory_of_the_graph",
    ),
    "test_numbers_sea.py": (
        "test_coast_and_limb_are_within_a_pixel_of_the_true_ones",
        "test_the_sea_lies_at_its_level",
        "test_dry_planets_are_refused",
    ),
    "test_tiles.py": (
        "test_edges_are_closed_to_the_last_bit[quadtree-True]",
        "test_backends_change_while_running[quadtree]",
    ),
    "test_forest_motion.py": ("test_what_may_be_dropped", "test_split_by_distance"),
    "test_snap_ahead.py": (
        "test_phases_come_in_their_order_and_only_those_somebody_does",
        "test_a_maker_that_begins_early_has_a_frame_more_and_does_less_in_it",
        "test_a_maker_that_leaves_ends_what_waits_for_it",
        "test_phases_take_all_of_the_frames",
        "test_parts_are_alike_and_whole_steps",
        "test_a_zoom_asks_for_a_snap_where_it_may_wait",
        "test_a_dive_into_the_sea_does_not_wait",
        "test_foresees_a_descent_and_level_flight",
        "test_what_was_foreseen_is_covered_on_the_way_there",
        "test_a_camera_that_waits_sees_no_hole",
    ),
    "test_overlay.py": (
        "test_is_the_finer_of_both_everywhere",
        "test_the_border_of_the_old_selection",
        "test_edges_to_cells_without_a_past_are_held",
        "test_of_a_selection_with_itself",
        "test_after_the_fade_the_picture_is_that_of_the_new_grid",
    ),
    "test_paper_grid.py": (
        "test_the_texture_shows_the_scenes_continents",
        "test_bounds_hold",
        "test_layers_are_checked",
        "test_heights_on_the_gpu",
        "test_vertices_are_where_float64_has_them[near]",
        "test_quality_paper_chooses_it",
    ),
    "test_height_gpu.py": ("test_heights_near_and_far", "test_heights_for_wide_pixels", "test_weights_are_the_twins"),
    "test_terrain_rays.py": (
        "test_rays_from_deep_below_hit_where_they_begin",
        "test_ground_stays_within_its_bound",
        "test_bad_rays_are_refused",
        "test_contacts_are_the_nearest_ground",
    ),
    "test_craters.py": (
        "test_fresh_craters_have_pikes_depths_and_rims",
        "test_density_one_covers_the_share_that_it_says",
        "test_gradients_are_the_slopes_of_the_heights",
        "test_heights_are_continuous_everywhere",
        "test_bounds_hold_and_the_slope_bound_does_nearly_always",
        "test_none_cost_nothing",
        "test_heights_on_the_gpu",
    ),
    "test_shadows.py": (
        "test_places_on_the_projection_come_back_and_lengths_scale_alike_in_all_directions",
        "test_a_projection_is_kept_until_another_is_clearly_nearer",
        "test_axes_of_projections_are_right_handed",
        "test_a_sweep_covers_all_that_a_shift_lets_see_further",
        "test_the_levels_reach_from_the_nearest_pixel_to_the_horizon",
        "test_a_camera_on_a_sea_that_hides_all_ground",
        "test_shadows_are_where_rays_to_the_sun_are_hidden[valley-14.0-0.06]",
        "test_without_shadows_nothing_runs_and_nothing_is_kept",
    ),
    "test_shade_every.py": ("test_outlines_are_the_same_and_every_pixel_has_light[coast]",),
    "test_ocean_system.py": (
        "test_a_dry_world_has_no_pass_of_the_sea",
        "test_no_hole",
        "test_the_sea_is_drawn_where_float64_has_it",
        "test_cells_agree_on_the_vertices_that_they_share",
        "test_no_wave_where_there_is_no_depth",
    ),
    "test_water_light.py": ("test_fresnel_from_both_sides", "test_light_from_all_of_the_sky"),
    "test_afloat.py": (
        "test_turning",
        "test_hulls_displace_their_shapes",
        "test_a_disc_bobs_with_its_period",
        "test_pictures",
        "test_bad_options",
        "test_a_wind_that_cannot_be",
    ),
    "test_coast_px.py": (),
    "test_coast_squares.py": (),
    "test_teleport.py": (),
    "test_shading_tiles.py": ("test_a_dry_planet_sorts_no_tiles",),
    "test_paper_icosphere.py": (
        "test_the_ground_is_where_ours_has_it",
        "test_what_is_drawn_is_what_the_recursion_leaves",
    ),
    "test_water_pictures.py": (
        "test_calm_water_mirrors_the_hills",
        "test_without_sea_nothing_of_it_runs",
        "test_a_dry_view_pays_for_no_water_before_the_lens",
    ),
    # air and clouds: tables, one answer of each kind, what they refuse
    "test_numbers_air.py": (
        "test_earth",
        "test_nothing_glows_on_the_night_side",
        "test_table_of_transmittance",
    ),
    "test_air_continuity.py": ("test_finite_and_never_negative", "test_the_night_side_does_not_glow"),
    "test_air_system.py": (
        "test_a_planet_without_air_has_nothing_of_it[moon]",
        "test_air_comes_and_goes",
        "test_what_does_not_change_does_not_run",
        "test_level_flight_under_an_equal_sun_fills_nothing",
        "test_a_change_shows_soon_and_refines",
        "test_a_bad_change_is_said_once_and_the_last_air_stays",
        "test_overrides_that_cannot_be_are_refused_before_any_gpu_work",
        "test_scene_files_that_cannot_be_are_refused",
        "test_a_reloaded_shader_shows",
    ),
    "test_air_paper.py": (
        "test_tables_are_what_the_printed_sums_give",
        "test_half_floats_are_rounded_to_nearest",
        "test_transmittance_to_space",
        "test_sizes_that_cannot_be_are_refused",
    ),
    "test_air_reference_light.py": (
        "test_without_scipy_the_message_says_what_to_do",
        "test_wrong_questions_are_named",
    ),
    "test_cloud_paper_pictures.py": (
        "test_the_noise_has_no_seam",
        "test_the_threshold_leaves_the_share_of_the_sky_that_is_asked_for",
        "test_every_camera_and_ray_sees_light",
        "test_methods_are_exchanged_while_a_renderer_runs",
    ),
    "test_cloud_shafts.py": (
        "test_heights_in_the_maps_cover_all_layers_once",
        "test_maps_of_the_shadow_have_the_depth_of_an_even_shell",
        "test_a_clear_sky_lets_all_light_through_and_more_cloud_less",
    ),
    "test_clouds_history.py": (
        "test_no_trail_in_fast_flight",
        "test_nothing_is_taken_over_by_a_jump",
    ),
    "test_clouds_pictures.py": (
        "test_no_pass_where_no_ray_can_meet_a_layer_or_nothing_is_covered",
        "test_clouds_that_are_not_there_leave_the_picture_as_it_is",
        "test_a_picture_by_itself_depends_on_nothing_before_it",
        "test_every_pixel_of_a_block_has_its_turn",
        "test_flight_shows_what_a_picture_by_itself_does",
    ),
    "test_antialiasing.py": (
        "test_samples_begin_in_the_centre_and_fill_the_pixel",
        "test_samples_measure_the_coverage_of_an_edge_as_a_grid_does",
        "test_motion_finds_where_a_point_was_seen",
        "test_stars_are_followed_and_not_the_planet",
        "test_a_settled_picture_stays_as_it_is",
        "test_without_it_there_is_no_pass_and_no_memory",
    ),
    "test_air_closing.py": ("test_work_that_raises_begins_anew_and_never_passes_for_done",),
    "test_march_every.py": tuple(f"test_every_ray_and_every_step_is_known[size{k}]" for k in (0, 4)),
    "test_cloud_picture_px.py": (),
    "test_paper_pictures.py": (),
    "test_cloud_no_cirrus.py": (),
    "test_views_weather.py": (),
    "test_antialiasing_props.py": (),
    "test_cloud_probe.py": (
        "test_shells_in_the_air_of_earth",
        "test_no_clouds_is_the_air_alone",
        "test_bad_questions_are_told_of",
    ),
    "test_cloud_probe_weather.py": (
        "test_uniform_layers_as_pictures_have_them_against_closed_form",
        "test_bad_questions_of_weather_are_told_of",
    ),
    # programs and windows: each starts once; what they refuse
    "test_app_interface.py": (
        "test_numbers_help_and_panels_are_drawn",
        "test_a_knob_changes_the_planet_in_the_next_frame_and_reset_brings_it_back",
        "test_texts",
    ),
    "test_photo.py": (
        "test_tiles_cover_the_picture_once",
        "test_plans_that_cannot_be",
        "test_samples_are_averaged_in_linear_light",
        "test_tiles_meet_and_are_the_whole_picture",
        "test_damaged_settings_are_errors_that_name_the_file",
    ),
    "test_rolling_stones.py": (
        "test_quaternions_of_frames",
        "test_stones_lie_within_the_ball_that_rolls",
        "test_pictures",
        "test_bad_options",
    ),
    "test_several_planets.py": (
        "test_what_cannot_be",
        "test_files_that_cannot_be",
        "test_saved_and_loaded",
        "test_a_circle_and_its_locked_face",
        "test_the_planet_turns_below_its_moon",
        "test_nothing_stands_before_the_nearest_planet",
        "test_bounds_of_a_disc",
        "test_a_disc_has_its_place_and_size[4.2]",
        "test_out_of_sight_costs_nothing",
    ),
    "test_bench_knobs.py": ("test_a_knob_has_times_values_and_a_difference", "test_the_bench_has_a_row_for_each_pair"),
    "test_tweak_lists.py": ("test_upright_turns_z_to_the_vertical",),
    "test_tweak_reliability.py": (),
    "test_endurance.py": (
        "test_a_lost_context_is_named_and_the_scene_kept",
        "test_a_lost_context_without_a_place_to_write",
    ),
    "test_endurance_planets.py": ("test_planets_come_and_go",),
    "test_render_views.py": ("test_what_is_shared_is_made_once",),
    "test_faults.py": (
        "test_the_sea_fails_and_the_ground_is_still_there",
        "test_what_nothing_can_be_drawn_without_raises_its_own_error",
        "test_without_being_tolerant_it_raises",
    ),
    "test_tutorials.py": ("test_the_first_picture_in_a_host_draws", "test_the_reference_is_current"),
    "test_host_state.py": (
        "test_no_binding_of_the_host_changes",
        "test_without_the_guard_no_error_is_left",
        "test_the_guard_covers_every_binding_that_a_shader_has",
    ),
    "test_embed.py": ("test_bare_moderngl", "test_the_first_picture_takes_ten_lines"),
    "test_stress_sweeps.py": (
        "test_cases_follow_from_the_seed_and_survive_json",
        "test_failures_are_counted_saved_and_run_again",
        "test_an_exception_is_a_failure_with_its_words",
        "test_replay_says_what_is_wrong_with_a_file",
        "test_command_line",
        "test_space_sweep",
        "test_holes_and_nan_are_seen",
    ),
}
"""File: what the default run takes of it, by function or by function[case]; () is nothing. Files that are not here it
takes whole."""

ONLY_ALL: dict[str, tuple[str, ...]] = {
    # further backends, sizes and places of what the default run shows with one of them
    "test_ground_seen.py": (
        "test_ground_that_comes_back_is_as_if_nobody_had_looked_away[100.0-6.0-110]",
        "test_ground_is_never_said_to_be_lower_than_it_is[mars]",
    ),
    "test_view_state.py": (
        "test_a_thousand_views_that_come_and_go_leave_nothing",
        *(f"test_a_released_view_leaves_nothing[{kind}]" for kind in ("quadtree-ours", "icosphere-ours", "grid-paper")),
    ),
    "test_freeze.py": (
        "test_every_ground_is_frozen_and_let_go[grid-paper]",
        "test_every_ground_is_frozen_and_let_go[quadtree-paper]",
        "test_every_ground_is_frozen_and_let_go[icosphere-ours]",
    ),
    "test_unseen.py": ("test_pictures_are_those_of_systems_that_never_rest[another sun]",),
    "test_cloud_sheets.py": (
        "test_under_a_sun_at_30_degrees[0.5-20000]",
        "test_under_a_sun_at_30_degrees[32.0-1500]",
    ),
    # the reference itself: what is measured against it is in the default run
    "test_cloud_reference.py": ("test_a_deep_slab_reflects_as_chandrasekhar_says", "test_slabs_of_all_orders[8.0]"),
    "test_air_reference.py": ("test_a_finer_tolerance_changes_nothing",),
    # comforts and tools, not what is drawn
    "test_app_journey_window.py": ("test_everything_in_the_window_does_what_it_says",),
    "test_places.py": ("test_a_damaged_file_is_put_aside_and_never_lost",),
    "test_memory_budget.py": ("test_estimates_are_what_is_then_there",),
    "test_bench_against.py": ("test_frames_of_a_commit_are_measured_beside_those_of_this_checkout",),
    "test_cloud_repeats.py": ("test_ours_don_t_show_and_the_printed_ones_do",),
    "test_debug_history.py": ("test_what_comes_into_view_has_no_history[cloud_history]",),
    "test_docs.py": ("test_the_diagram_is_that_of_the_program",),
    "test_air_cache.py": ("test_the_key_tells_all_that_matters_apart", "test_two_processes_at_once"),
    "test_bench_harness.py": ("test_graph_suite_runs",),
    "test_app.py": ("test_flies_in_a_real_window[pyglet]",),
    "test_sky.py": ("test_an_automatic_exposure_hides_what_cannot_show_and_nothing_else",),
    "test_demo.py": ("test_the_graph_is_shown",),
    "test_app_planets.py": (
        "test_the_knobs_of_a_companion",
        "test_objects_of_all_planets_are_listed_placed_and_removed",
    ),
}
"""File: what the default run leaves out of it; it takes all else."""


def of_default(file: str, test: str) -> bool:
    """Whether the default run takes a test: file "test_sky.py", test "test_stars" or "test_stars[bright]"."""
    names = {test, test.split("[", maxsplit=1)[0]}
    return not names & set(ONLY_ALL.get(file, ())) and (file not in DEFAULT or bool(names & set(DEFAULT[file])))


def skip_if_results_are_new(results: Path) -> None:
    """Skip a test of pages made of benches' results while somebody's own lie there, which no page is made of yet."""
    command = ["git", "status", "--porcelain", "--", str(results)]
    try:
        new = subprocess.run(command, cwd=results, check=True, capture_output=True, timeout=60).stdout
    except (OSError, subprocess.SubprocessError):
        return  # an unpacked archive
    if new:
        pytest.skip("results that are not committed: planetfall bench --document makes the page of them")


def files_named(arguments: Iterable[str]) -> set[Path]:
    """Files among pytest's arguments, by themselves or with a test's name; folders don't count."""
    paths = (Path(argument.split("::")[0]) for argument in arguments)
    return {path.resolve() for path in paths if path.suffix == ".py"}
