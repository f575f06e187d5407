// The interpreter: reflectance of a program on one block of samples. CPU twin: execute.rs of
// brood-program over a `Tape`. encode.rs defines the words of programs. shader.rs generates the
// rest of the text: operation numbers, widths, `hold`, and `load` and `store` of registers.

struct Place {
    // Index of the block in a row of inputs.
    block: u32,
    // Column of the register file in workgroup memory: the index of the invocation.
    column: u32,
}

// The f32 in a word.
fn number(at: u32) -> V {
    return V(bitcast<f32>(words[at]));
}

// Value of an operand: a kind above an index. `constants` is the word of the first constant.
fn fetch(operand: u32, constants: u32, place: Place) -> V {
    let index = operand & INDEX_MASK;
    switch operand >> INDEX_BITS {
        case KIND_REGISTER: {
            return load(index, place.column);
        }
        case KIND_INPUT: {
            return inputs[index * tile.stride + place.block];
        }
        default: {
            return number(constants + index);
        }
    }
}

// Result of an operation. Operations that differ only in a sign or an argument share a case.
fn execute(operation: u32, a: V, b: V) -> V {
    switch operation {
        case OP_ADD, OP_SUB: {
            // Negation is exact, so a - b is a + (-b).
            return limit(hold(a + select(b, -b, operation == OP_SUB)));
        }
        case OP_MUL: {
            return limit(product(a, b));
        }
        case OP_SIN, OP_COS: {
            return sine(a, select(0, 1, operation == OP_COS));
        }
        case OP_EX2, OP_EX2_NEG: {
            return ex2(select(a, -a, operation == OP_EX2_NEG));
        }
        case OP_LG2, OP_SPL, OP_SPL_NEG: {
            let x = select(a, -a, operation == OP_SPL_NEG);
            let is_lg2 = operation == OP_LG2;
            let argument = select(hold(V(1.0) + ex2(-abs(x))), softened_square(x), is_lg2);
            let logarithm = log2_of(argument);
            let positive = select(V(0.0), x, x > V(0.0));
            return select(limit(hold(positive + logarithm)), logarithm, is_lg2);
        }
        case OP_RCP: {
            return rcp(a);
        }
        case OP_RSQ: {
            return rsq(a);
        }
        case OP_SAT, OP_SAT_NEG: {
            return limit_to(select(a, -a, operation == OP_SAT_NEG), 0.0, 1.0);
        }
        case OP_STEP, OP_STEP_NEG: {
            return is_positive(select(a, -a, operation == OP_STEP_NEG));
        }
        default: {
            return V(0.0);
        }
    }
}

// f of a program: its steps, then the squares of its results through the output stage; or its
// results, if they are colours.
fn reflectance(program: u32, place: Place) -> array<V, 3> {
    let entry = program * ENTRY_WORDS;
    let end = words[entry + 1u];
    let constants = words[entry + 2u];
    for (var at = words[entry]; at < end; at += 2u) {
        let head = words[at];
        let operands = words[at + 1u];
        let a = fetch(operands & 0xffffu, constants, place);
        let b = fetch(operands >> 16u, constants, place);
        store(head & 0xffffu, place.column, execute(head >> 16u, a, b));
    }
    let red = fetch(words[entry + 3u], constants, place);
    let green = fetch(words[entry + 4u], constants, place);
    let blue = fetch(words[entry + 5u], constants, place);
    if words[entry + 21u] == 1u {
        return array<V, 3>(red, green, blue);
    }
    let squares = array<V, 3>(product(red, red), product(green, green), product(blue, blue));
    // Nine numbers of the matrix, row by row, then three scales and three offsets.
    let output = entry + 6u;
    var f: array<V, 3>;
    for (var channel = 0u; channel < 3u; channel += 1u) {
        let row = output + 3u * channel;
        let first = product(squares[0], number(row));
        let second = hold(product(squares[1], number(row + 1u)) + first);
        let mixed = hold(product(squares[2], number(row + 2u)) + second);
        let scaled = product(mixed, number(output + 9u + channel));
        f[channel] = hold(scaled + number(output + 12u + channel));
    }
    return f;
}
