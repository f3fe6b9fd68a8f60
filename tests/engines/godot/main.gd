# A relief on the base, felt and seen: Godot draws the glTF file that omnid makes forces of, and in the right hand the model that OpenXR
# gives it (XR_EXT_interaction_render_model), else a pen of its own. Godot knows nothing of Omni: the pen is a controller, bound by
# Godot's default action map.
#
# Prints a JSON line per second, with what a game sees of the hand. With --port N (scripts/headset) it sends where the mouse leads
# the pen, and shows the force that comes back; with --film FOLDER it saves a picture every 100 ms.
extends Node3D

const BASE_m := Vector3(0.1, 0.74, -0.5)  # scripts/simulated/stand.py
const HULL_m := 0.0375
const FRAME_ms := 100
const LIFTED_m := 0.075  # of the base; where the pen waits
const UNSEEN := 0.001
const LOWEST_m := 0.040

var hand: XRController3D
var pen: Node3D
var models_shown := 0  # of the right hand
var label: Label
var arrow: MeshInstance3D
var camera: Camera3D
var link := PacketPeerUDP.new()
var film := ""
var next_frame_ms := 0
var pictures := 0
var shown := ""  # in the corner of the frame before
var force := Vector3.ZERO  # of the base, in Godot's axes
var frames := 0
var presses := 0
var pulses := 0
var pressed := false
var next_line_ms := 1000
var aim := Vector3(0, LIFTED_m, 0)  # of the base, in Godot's axes


func _ready() -> void:
	var words := OS.get_cmdline_user_args()
	for i in range(0, words.size() - 1, 2):
		match words[i]:
			"--port":
				link.connect_to_host("127.0.0.1", int(words[i + 1]))
			"--film":
				film = words[i + 1]
	var openxr := XRServer.find_interface("OpenXR")
	if openxr == null or not openxr.is_initialized():
		printerr("no OpenXR session: is a runtime active?")
		get_tree().quit(1)
		return
	Engine.max_fps = 0
	add_headset()
	add_scene()
	add_corner()


# The headset's eyes are a viewport of their own; the window shows the same world from the side.
func add_headset() -> void:
	var eyes := SubViewport.new()
	eyes.use_xr = true
	eyes.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	add_child(eyes)
	var origin := XROrigin3D.new()
	eyes.add_child(origin)
	origin.add_child(XRCamera3D.new())
	hand = XRController3D.new()
	hand.tracker = "right_hand"
	origin.add_child(hand)
	pen = Node3D.new()
	hand.add_child(pen)  # -Z out of the tip
	pen.add_child(part(cone(0.0, 0.004, 0.014), Color(0.1, 0.1, 0.12), Vector3(0, 0, 0.007)))
	pen.add_child(part(cone(0.004, 0.0045, 0.11), Color(0.92, 0.92, 0.9), Vector3(0, 0, 0.069)))
	pen.add_child(part(cone(0.0047, 0.0047, 0.008), Color(0.95, 0.55, 0.1), Vector3(0, 0, 0.018)))
	var models := OpenXRRenderModelManager.new()
	models.tracker = OpenXRRenderModelManager.RENDER_MODEL_TRACKER_RIGHT_HAND
	models.render_model_added.connect(show_model.bind(1))
	models.render_model_removed.connect(show_model.bind(-1))
	origin.add_child(models)


func show_model(_model: OpenXRRenderModel, change: int) -> void:
	models_shown += change
	pen.visible = models_shown == 0


func cone(front_m: float, back_m: float, length_m: float) -> Mesh:
	var mesh := CylinderMesh.new()
	mesh.top_radius = back_m
	mesh.bottom_radius = front_m
	mesh.height = length_m
	mesh.radial_segments = 20
	mesh.rings = 1
	return mesh


# A cylinder along z, with the side that is "bottom" to -z.
func part(mesh: Mesh, colour: Color, at: Vector3) -> MeshInstance3D:
	var instance := MeshInstance3D.new()
	var material := StandardMaterial3D.new()
	material.albedo_color = colour
	material.roughness = 0.4
	mesh.surface_set_material(0, material)
	instance.mesh = mesh
	instance.rotation = Vector3(PI / 2, 0, 0)
	instance.position = at
	return instance


func add_scene() -> void:
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	if document.append_from_file("res://relief.glb", state) != OK:
		printerr("relief.glb cannot be read")
		get_tree().quit(1)
		return
	var base := Node3D.new()
	base.position = BASE_m
	add_child(base)
	base.add_child(document.generate_scene(state))
	var ball := SphereMesh.new()
	ball.radius = HULL_m
	ball.height = 2 * HULL_m
	base.add_child(part(ball, Color(0.16, 0.17, 0.2), Vector3.ZERO))
	var desk := BoxMesh.new()
	desk.size = Vector3(1.2, 0.6, 0.02)
	base.add_child(part(desk, Color(0.55, 0.42, 0.3), Vector3(0, -HULL_m - 0.01, 0)))
	arrow = part(cone(0.0012, 0.0012, 1.0), Color(0.9, 0.1, 0.1), Vector3.ZERO)
	arrow.scale = Vector3.ONE * UNSEEN
	(arrow.mesh.surface_get_material(0) as StandardMaterial3D).no_depth_test = true  # also within the pen
	base.add_child(arrow)
	var sun := DirectionalLight3D.new()
	sun.rotation = Vector3(-0.9, 0.7, 0)
	add_child(sun)
	var around := WorldEnvironment.new()
	around.environment = Environment.new()
	around.environment.background_mode = Environment.BG_COLOR
	around.environment.background_color = Color(0.78, 0.82, 0.86)
	around.environment.ambient_light_source = Environment.AMBIENT_SOURCE_COLOR
	around.environment.ambient_light_color = Color(0.8, 0.85, 0.9)
	around.environment.ambient_light_energy = 0.5
	add_child(around)
	camera = Camera3D.new()
	camera.fov = 22
	camera.near = 0.01
	add_child(camera)
	camera.look_at_from_position(BASE_m + Vector3(0.07, 0.17, 0.2), BASE_m + Vector3(0, 0.064, 0))
	camera.make_current()


func add_corner() -> void:
	var layer := CanvasLayer.new()
	add_child(layer)
	label = Label.new()
	label.position = Vector2(14, 10)
	label.add_theme_font_size_override("font_size", 34)
	label.add_theme_color_override("font_color", Color(0.1, 0.1, 0.12))
	layer.add_child(label)
	var note := Label.new()
	note.text = "Godot %s on Monado. Simulated: headset, base, pen, arm" % Engine.get_version_info()["string"].get_slice(".stable", 0).get_slice("-", 0)
	note.position = Vector2(14, 366)
	note.add_theme_font_size_override("font_size", 16)
	note.add_theme_color_override("font_color", Color.WHITE)
	layer.add_child(note)


func _process(_delta: float) -> void:
	frames += 1
	read_hand()
	exchange()
	var now_ms := Time.get_ticks_msec()
	if now_ms >= next_line_ms:
		next_line_ms = now_ms + 1000
		report()
	if film != "" and now_ms >= next_frame_ms:
		next_frame_ms = now_ms + FRAME_ms
		save_picture()
	show_force()
	shown = label.text


# A game's way to a button: the action that the default map binds to triggers, and the one for hands that have only "select".
func read_hand() -> void:
	var now := hand.get_float("trigger") > 0.5 or hand.is_button_pressed("select_button")
	if now and not pressed:
		presses += 1
		hand.trigger_haptic_pulse("haptic", 150.0, 0.3, 0.03, 0.0)
		pulses += 1
	pressed = now


func report() -> void:
	var tracker := XRServer.get_tracker("right_hand") as XRPositionalTracker
	var profile: String = tracker.profile if tracker != null else ""
	var at := hand.global_position
	print(JSON.stringify({"frames": frames, "profile": profile, "tracked": hand.get_has_tracking_data(), "presses": presses,
		"pulses": pulses, "models": models_shown, "position_m": [at.x, at.y, at.z]}))


# Both ways with scripts/headset, each packet a text: the aim out, the force in, in the base's own axes (z up).
func exchange() -> void:
	if not link.is_socket_connected():
		return
	link.put_packet(("aim %f %f %f" % [aim.x, -aim.z, aim.y]).to_utf8_buffer())
	while link.get_available_packet_count() > 0:
		var numbers := link.get_packet().get_string_from_utf8().split_floats(" ")
		if numbers.size() == 3:
			force = Vector3(numbers[0], numbers[2], -numbers[1])


# The mouse leads the pen in a plane that faces the camera; the wheel moves it away and back.
func _input(event: InputEvent) -> void:
	if event is InputEventMouseMotion:
		var right := camera.global_basis.x
		right.y = 0
		aim += 0.00025 * (event.relative.x * right.normalized() - event.relative.y * Vector3.UP)
	elif event is InputEventMouseButton and event.pressed:
		var ahead := -camera.global_basis.z
		ahead.y = 0
		var step: float = {MOUSE_BUTTON_WHEEL_UP: 0.001, MOUSE_BUTTON_WHEEL_DOWN: -0.001}.get(event.button_index, 0.0)
		aim += step * ahead.normalized()
	aim = aim.clamp(Vector3(-0.04, LOWEST_m, -0.04), Vector3(0.04, 0.11, 0.04))


# Never invisible: what is drawn for the first time has to be compiled, which takes seconds in software.
func show_force() -> void:
	var newtons := force.length()
	label.text = "%.2f N" % newtons
	if newtons < 0.05 or not hand.get_has_tracking_data():
		arrow.transform = Transform3D(Basis().scaled(Vector3.ONE * UNSEEN), Vector3.ZERO)
		return
	var length := 0.03 * newtons
	var up := force / newtons
	var across := up.cross(Vector3.RIGHT if absf(up.x) < 0.9 else Vector3.UP).normalized()
	arrow.transform = Transform3D(Basis(across, up * length, across.cross(up)), hand.global_position - BASE_m + 0.5 * length * up)


# The picture is of the frame before, and so is what its corner showed.
func save_picture() -> void:
	var picture := get_viewport().get_texture().get_image()
	if picture == null or shown == "":
		return
	link.put_packet(("picture %d %s" % [pictures, shown]).to_utf8_buffer())
	picture.save_png("%s/%05d.png" % [film, pictures])
	pictures += 1
