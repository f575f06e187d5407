# Draws the points of scene.json with each shader under each light, and writes the pixels.
extends Node


func read(path):
	var file = File.new()
	file.open(path, File.READ)
	return file.get_as_text()


func points_of(rows, picture):
	var arrays = []
	arrays.resize(ArrayMesh.ARRAY_MAX)
	var places = PoolVector3Array()
	var normals = PoolVector3Array()
	var tangents = PoolRealArray()
	var uvs = PoolVector2Array()
	for row in rows:
		if int(row[0]) == picture:
			places.append(Vector3(row[1], row[2], row[3]))
			normals.append(Vector3(row[4], row[5], row[6]))
			tangents.append_array(PoolRealArray([row[7], row[8], row[9], 1.0]))
			uvs.append(Vector2(row[10], row[11]))
	arrays[ArrayMesh.ARRAY_VERTEX] = places
	arrays[ArrayMesh.ARRAY_NORMAL] = normals
	arrays[ArrayMesh.ARRAY_TANGENT] = tangents
	arrays[ArrayMesh.ARRAY_TEX_UV] = uvs
	var mesh = ArrayMesh.new()
	# Without compression, which rounds normals to 8 bits.
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_POINTS, arrays, [], 0)
	mesh.custom_aabb = AABB(Vector3(-1e6, -1e6, -1e6), Vector3(2e6, 2e6, 2e6))
	var shown = MeshInstance.new()
	shown.mesh = mesh
	shown.visible = false
	return shown


func _ready():
	var description = parse_json(read("res://scene.json"))
	var view = Viewport.new()
	view.size = Vector2(description.side, description.side)
	view.hdr = true
	view.keep_3d_linear = true
	view.own_world = true
	view.render_target_update_mode = Viewport.UPDATE_ALWAYS
	add_child(view)
	var camera = Camera.new()
	camera.projection = Camera.PROJECTION_ORTHOGONAL
	camera.size = 2
	camera.near = 1e-5
	camera.far = 1e7
	camera.environment = Environment.new()
	camera.environment.background_mode = Environment.BG_COLOR
	view.add_child(camera)
	camera.current = true
	var light = DirectionalLight.new()
	view.add_child(light)
	var meshes = []
	for picture in range(description.lights.size()):
		var shown = points_of(description.points, picture)
		meshes.append(shown)
		view.add_child(shown)
	var written = File.new()
	written.open("res://pixels.bin", File.WRITE)
	for k in range(description.files.size()):
		var shader = Shader.new()
		shader.code = read("res://" + description.files[k])
		var material = ShaderMaterial.new()
		material.shader = shader
		light.light_energy = description.energies[k]
		for picture in range(meshes.size()):
			var to = description.lights[picture]
			var direction = Vector3(to[0], to[1], to[2])
			var up = Vector3(0, 1, 0)
			# A light shines along its -z axis.
			light.transform = Transform(up.cross(direction), up, direction, Vector3())
			for other in meshes:
				other.visible = false
			meshes[picture].material_override = material
			meshes[picture].visible = true
			yield(VisualServer, "frame_post_draw")
			yield(VisualServer, "frame_post_draw")
			var image = view.get_texture().get_data()
			if image.get_format() != Image.FORMAT_RGBAH:
				printerr("the viewport has no half floats")
				get_tree().quit(1)
				return
			written.store_buffer(image.get_data())
	written.close()
	get_tree().quit()
